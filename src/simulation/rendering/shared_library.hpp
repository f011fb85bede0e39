// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <dlfcn.h>

#include <initializer_list>
#include <string>

namespace palpate::simulation {

/// A library that is loaded, if it is there, while the program runs. It stays loaded: drivers do
/// not survive being unloaded.
class SharedLibrary {
 public:
  /// Takes the first of the names that loads; its symbols stay private.
  explicit SharedLibrary(std::initializer_list<const char*> names) {
    for (const char* name : names) {
      handle_ = dlopen(name, RTLD_NOW | RTLD_LOCAL);
      name_ = name;
      if (handle_) return;
    }
  }

  /// The function of that name; null if it or the library is missing.
  template <class Function>
  void find(const char* name, Function*& function) const {
    function = handle_ ? reinterpret_cast<Function*>(dlsym(handle_, name)) : nullptr;
  }

  /// Shows the library's symbols to the whole process.
  void publish() const { dlopen(name_.c_str(), RTLD_NOW | RTLD_GLOBAL | RTLD_NOLOAD); }

 private:
  void* handle_ = nullptr;
  std::string name_;
};

}  // namespace palpate::simulation
