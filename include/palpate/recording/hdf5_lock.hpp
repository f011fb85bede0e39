// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>

namespace palpate::recording {

/// Held around every use of HDF5, whose library is not safe for threads.
inline std::mutex& hdf5_mutex() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace palpate::recording
