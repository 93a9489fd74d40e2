// Stands in for the library of a sensor: the x axis of the gyroscope numbers the samples.
#pragma once
#include "Arduino.h"

struct {
  bool is_on = false;
  int begin() { return is_on = true; }
  int gyroscopeAvailable() {  // every other time
    static bool is_new = false;
    usleep(500);
    is_new = is_on && !is_new;
    samples += is_new;
    return is_new;
  }
  int readGyroscope(float &x, float &y, float &z) {
    x = samples % 7;
    y = -90;
    z = 0.125;
    return 1;
  }
  int readAcceleration(float &x, float &y, float &z) {
    x = y = 0;
    z = 1;
    return 1;
  }
} IMU;
