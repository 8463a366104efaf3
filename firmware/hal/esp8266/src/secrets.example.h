/* Copy to secrets.h (which git ignores), or let the fleet's command line write it:
 *   python -m hero_robot.fleet secrets fleet.yaml hero_3 > firmware/hal/esp8266/src/secrets.h */
#ifndef HERO_SECRETS_H
#define HERO_SECRETS_H

#define HERO_WIFI_NAME "the lab's network"
#define HERO_WIFI_PASSWORD "its password"
#define HERO_ROBOT 3
#define HERO_KEY "0000000000000000000000000000000000000000000000000000000000000000" /* 64 hexadecimal digits, this robot's own */
#define HERO_HALT_LEFT_US 0  /* measured halt pulse, us; 0: the robot file's */
#define HERO_HALT_RIGHT_US 0

#endif
