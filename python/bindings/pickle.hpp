// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <typeinfo>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "palpate/core/error.hpp"

namespace palpate::python {

/// The members by which a plain struct is kept in a pickle: a specialisation for each such struct
/// has a static of(value), which ties them, and, where not every value will do, a static
/// check(value), which throws BadInput. A pickle is of the same version of the package.
template <class T>
struct Fields;

template <class T>
concept HasFields = requires(T& value) {
  Fields<T>::of(value);
};
template <class T>
concept HasCheck = requires(const T& value) {
  Fields<T>::check(value);
};

/// What a pickle keeps of a value, and the value again. Numbers, strings and matrices are kept as
/// nanobind converts them, structs as tuples of their fields.
template <class T>
struct Kept {
  static nb::object of(const T& value) {
    if constexpr (HasFields<T>) {
      return std::apply(
          [](const auto&... member) {
            return nb::object(
                nb::make_tuple(Kept<std::remove_cvref_t<decltype(member)>>::of(member)...));
          },
          Fields<T>::of(const_cast<T&>(value)));  // NOLINT: it is only read
    } else if constexpr (std::is_enum_v<T>) {
      return nb::int_(static_cast<int>(value));
    } else {
      return nb::cast(value);
    }
  }

  static void into(nb::handle kept, T& value) {
    if constexpr (HasFields<T>) {
      auto members = Fields<T>::of(value);
      constexpr std::size_t kCount = std::tuple_size_v<decltype(members)>;
      const auto parts = nb::cast<nb::tuple>(kept);
      if (parts.size() != kCount) {
        throw BadInput(fmt::format("a state of {} values, not {}: of another version of palpate?",
                                   parts.size(), kCount));
      }
      std::size_t next = 0;
      std::apply(
          [&](auto&... member) {
            (Kept<std::remove_cvref_t<decltype(member)>>::into(parts[next++], member), ...);
          },
          members);
      if constexpr (HasCheck<T>) Fields<T>::check(value);
    } else if constexpr (std::is_enum_v<T>) {
      value = static_cast<T>(nb::cast<int>(kept));
    } else {
      value = nb::cast<T>(kept);
    }
  }
};

template <>
struct Kept<Eigen::Isometry3d> {
  static nb::object of(const Eigen::Isometry3d& T) { return nb::cast(pose(T)); }
  static void into(nb::handle kept, Eigen::Isometry3d& T) { T = pose_from(kept, "state"); }
};

template <>
struct Kept<std::vector<Eigen::Vector3d>> {
  static nb::object of(const std::vector<Eigen::Vector3d>& points) {
    return nb::cast(rows(points));
  }
  static void into(nb::handle kept, std::vector<Eigen::Vector3d>& points) {
    points = points_from(kept, "state");
  }
};

template <class T>
struct Kept<std::optional<T>> {
  static nb::object of(const std::optional<T>& value) {
    return value ? Kept<T>::of(*value) : nb::none();
  }
  static void into(nb::handle kept, std::optional<T>& value) {
    value.reset();
    if (!kept.is_none()) Kept<T>::into(kept, value.emplace());
  }
};

template <class T>
struct Kept<std::vector<T>> {
  static nb::object of(const std::vector<T>& values) {
    nb::list kept;
    for (const T& value : values) kept.append(Kept<T>::of(value));
    return kept;
  }
  static void into(nb::handle kept, std::vector<T>& values) {
    values.clear();
    for (const nb::handle one : nb::cast<nb::list>(kept)) Kept<T>::into(one, values.emplace_back());
  }
};

template <class T>
struct Kept<std::map<std::string, T>> {
  static nb::object of(const std::map<std::string, T>& values) {
    nb::dict kept;
    for (const auto& [name, value] : values) kept[name.c_str()] = Kept<T>::of(value);
    return kept;
  }
  static void into(nb::handle kept, std::map<std::string, T>& values) {
    values.clear();
    for (const auto& [name, value] : nb::cast<nb::dict>(kept)) {
      Kept<T>::into(value, values[nb::cast<std::string>(name)]);
    }
  }
};

/// The value that a state is of.
/// @throws BadInput for a state that is none, or is damaged
template <class T>
T restored(nb::handle state) {
  T value{};
  try {
    Kept<T>::into(state, value);
  } catch (const std::bad_cast&) {
    throw BadInput("a state holds a value of another type: of another version of palpate?");
  }
  return value;
}

/// Lets pickle and copy.deepcopy() take a struct by its Fields.
template <class T, class... Extra>
void bind_pickle(nb::class_<T, Extra...>& bound) {
  bound.def("__getstate__", [](const T& self) { return Kept<T>::of(self); })
      .def("__setstate__", [](T* self, nb::object state) { new (self) T(restored<T>(state)); });
}

}  // namespace palpate::python
