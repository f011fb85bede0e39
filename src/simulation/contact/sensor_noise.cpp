// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/contact/sensor_noise.hpp"

namespace palpate::simulation {

SensorNoise SensorNoise::realistic() {
  SensorNoise noise;
  noise.load = 0.1;
  noise.mount = 0.0001;
  noise.mount_angle = 0.0005;
  noise.mount_delay = 0.02;
  noise.touch_delay = 0.01;
  noise.touch_threshold = 0.05;
  return noise;
}

}  // namespace palpate::simulation
