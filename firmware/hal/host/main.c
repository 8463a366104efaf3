/* The robot as a program on this machine: the robot's own code, simulated parts, a real UDP socket and real time.
 *
 *   hero_host ROBOT PORT KEY_HEX [SEEN_PERIOD_MS]
 *
 * Listens on 127.0.0.1 only. Each change of state or of the servos is a line on standard output:
 *   {"ns": CLOCK_MONOTONIC, "robot": 3, "state": 2, "reason": 2, "driven": true, "version": 1}
 * With SEEN_PERIOD_MS something stands before the sensor for half of each such period. Ends when standard input does. */
#define _POSIX_C_SOURCE 200809L
#define _DARWIN_C_SOURCE  // macOS hides MSG_DONTWAIT from strict POSIX

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "../sim/hero_sim.h"

static int sock;
static struct hero_sim sim;

static uint64_t monotonic_ns(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

static size_t receive(void *context, uint8_t *data, size_t room, struct hero_peer *from) {
  struct sockaddr_in address;
  socklen_t length = sizeof address;
  (void)context;
  ssize_t size = recvfrom(sock, data, room, MSG_DONTWAIT, (struct sockaddr *)&address, &length);
  if (size <= 0) return 0;
  *from = (struct hero_peer){.address = address.sin_addr.s_addr, .port = address.sin_port};
  return (size_t)size;
}

static void send_to(void *context, const uint8_t *data, size_t size, struct hero_peer to) {
  struct sockaddr_in address = {.sin_family = AF_INET, .sin_port = to.port, .sin_addr = {to.address}};
  (void)context;
  sendto(sock, data, size, MSG_DONTWAIT, (struct sockaddr *)&address, sizeof address);
}

static uint64_t random64(void *context) {
  uint64_t number = 0;
  (void)context;
  if (getentropy(&number, sizeof number) != 0) return 0;
  return number;
}

static bool parse_key(const char *hex, uint8_t key[HERO_KEY_SIZE]) {
  if (strlen(hex) != 2 * HERO_KEY_SIZE) return false;
  for (unsigned i = 0; i < HERO_KEY_SIZE; i++) {
    unsigned byte;
    if (sscanf(hex + 2 * i, "%2x", &byte) != 1) return false;
    key[i] = (uint8_t)byte;
  }
  return true;
}

static bool open_socket(uint16_t port) {
  struct sockaddr_in address = {.sin_family = AF_INET, .sin_port = htons(port), .sin_addr = {htonl(INADDR_LOOPBACK)}};
  sock = socket(AF_INET, SOCK_DGRAM, 0);
  return sock >= 0 && bind(sock, (struct sockaddr *)&address, sizeof address) == 0;
}

static void tell_changes(void) {
  static int last = -1;
  const struct hero_supervisor *supervisor = &sim.robot.supervisor;
  bool driven = sim.wheel[0].pulse_us != 0 || sim.wheel[1].pulse_us != 0;
  int now = supervisor->state * 2 + driven + (int)supervisor->version * 16;
  if (now == last) return;
  last = now;
  printf("{\"ns\": %llu, \"robot\": %u, \"state\": %u, \"reason\": %u, \"driven\": %s, \"version\": %lu}\n",
         (unsigned long long)monotonic_ns(), sim.settings.robot, supervisor->state, supervisor->reason, driven ? "true" : "false",
         (unsigned long)supervisor->version);
  fflush(stdout);
}

static bool input_ended(void) {
  char byte;
  return read(STDIN_FILENO, &byte, 1) == 0;
}

int main(int count, char **arguments) {
  uint8_t key[HERO_KEY_SIZE];
  long robot = count > 1 ? atol(arguments[1]) : 0, port = count > 2 ? atol(arguments[2]) : 0;
  uint64_t seen_ms = count > 4 ? (uint64_t)atol(arguments[4]) : 0;
  if (count < 4 || robot < 1 || robot > 65535 || port < 1 || port > 65535 || !parse_key(arguments[3], key)) {
    fprintf(stderr, "hero_host: expected ROBOT PORT KEY [SEEN_PERIOD_MS], the key as 64 hexadecimal digits\n");
    return 2;
  }
  if (!open_socket((uint16_t)port)) {
    fprintf(stderr, "hero_host: port %ld of 127.0.0.1 cannot be had; give a free one\n", port);
    return 2;
  }
  fcntl(STDIN_FILENO, F_SETFL, O_NONBLOCK);
  hero_sim_init(&sim, (uint16_t)robot, key, (uint64_t)robot);
  sim.hal.receive = receive;
  sim.hal.send = send_to;
  sim.hal.random64 = random64;
  hero_sim_boot(&sim);
  uint64_t start_ns = monotonic_ns();
  while (!input_ended()) {
    struct pollfd waiting = {.fd = sock, .events = POLLIN};
    poll(&waiting, 1, 2);
    uint64_t now_us = (monotonic_ns() - start_ns) / 1000u;
    if (seen_ms > 0) sim.distance_m = now_us / 1000u % seen_ms < seen_ms / 2 ? 0.3 : 0.0;
    hero_sim_run(&sim, now_us);
    tell_changes();
  }
  return 0;
}
