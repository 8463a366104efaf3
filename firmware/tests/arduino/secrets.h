#include "../../hal/esp8266/src/secrets.example.h"
