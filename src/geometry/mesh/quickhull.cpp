// SPDX-License-Identifier: Apache-2.0
#include "geometry/mesh/quickhull.hpp"

#include <string>
#include <utility>

namespace palpate::geometry {

Quickhull::Quickhull(Eigen::MatrixXd points, const char* options)
    : points_(std::move(points)), messages_(std::fopen("/dev/null", "w")) {
  qh_zero(&state_, messages_);
  std::string command = std::string("qhull ") + options;
  error_ = qh_new_qhull(&state_, static_cast<int>(points_.rows()), static_cast<int>(points_.cols()),
                        points_.data(), False, command.data(), messages_, messages_);
}

Quickhull::~Quickhull() {
  qh_freeqhull(&state_, qh_ALL);
  int kept = 0, total = 0;
  qh_memfreeshort(&state_, &kept, &total);
  if (messages_) std::fclose(messages_);
}

}  // namespace palpate::geometry
