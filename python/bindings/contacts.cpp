// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <tuple>
#include <vector>

#include "arrays.hpp"
#include "libraries.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/error.hpp"
#include "palpate/localization/contacts_io.hpp"
#include "without_gil.hpp"

namespace palpate::python {
namespace {

using namespace nb::literals;
using Optional3 = std::optional<Rows3>;

constexpr double kPointSigma = 0.001, kNormalSigma = 10 * kDegree;

std::vector<Eigen::Vector3d> as_many(nb::handle values, std::size_t count, std::string_view what) {
  const auto result = points_from(values, what);
  if (result.size() != count) {
    throw BadInput(fmt::format("{}: {} for {} points", what, result.size(), count));
  }
  return result;
}

/// Rows of nan, or of zeros, are contacts whose normal is not known.
Eigen::Vector3d unit_or_none(const Eigen::Vector3d& n, std::size_t index) {
  if (n.array().isNaN().all() || n.isZero(0)) return Eigen::Vector3d::Zero();
  if (!(n.allFinite() && n.stableNorm() > 1e-6)) {
    throw BadInput(fmt::format("normal {} is ({}, {}, {})", index, n.x(), n.y(), n.z()));
  }
  return n.stableNormalized();
}

void check_finite(const Eigen::Vector3d& v, const char* what, std::size_t index) {
  if (v.allFinite()) return;
  throw BadInput(
      fmt::format("contact {}: {} is ({}, {}, {}), not finite", index, what, v.x(), v.y(), v.z()));
}

void check_sigma(double sigma, const char* what, std::size_t index) {
  if (sigma > 0 && std::isfinite(sigma)) return;
  throw BadInput(fmt::format("contact {}: {} is {}, not positive", index, what, sigma));
}

/// @throws BadInput for what no contact can be
void check_contact(const tactile::Contact& contact, std::size_t index) {
  check_finite(contact.p, "point", index);
  check_finite(contact.n, "normal", index);
  check_finite(contact.f, "force", index);
  check_sigma(contact.point_sigma, "point_sigma", index);
  check_sigma(contact.normal_sigma, "normal_sigma", index);
}

/// @throws BadInput for errors that are none: millimetres, degrees
void check_stated(const tactile::Contact& contact, std::size_t index) {
  if (contact.point_sigma > localization::kMaxPointSigma) {
    throw BadInput(fmt::format("contact {}: point_sigma is {} m, more than {}; is it in mm?", index,
                               contact.point_sigma, localization::kMaxPointSigma));
  }
  if (contact.normal_sigma > std::numbers::pi / 2) {
    throw BadInput(fmt::format("contact {}: normal_sigma is {} rad, more than pi/2; is it in deg?",
                               index, contact.normal_sigma));
  }
}

Contacts make_contacts(nb::handle points, nb::handle normals, nb::handle forces, nb::handle sigma,
                       nb::handle normal_sigma) {
  const auto p = points_from(points, "points");
  Contacts contacts{std::vector<tactile::Contact>(p.size())};
  for (std::size_t k = 0; k < p.size(); ++k) contacts.list[k].p = p[k];
  if (is_given(normals)) {
    const auto n = as_many(normals, p.size(), "normals");
    for (std::size_t k = 0; k < n.size(); ++k) contacts.list[k].n = unit_or_none(n[k], k);
  }
  if (is_given(forces)) {
    const auto f = as_many(forces, p.size(), "forces");
    for (std::size_t k = 0; k < f.size(); ++k) contacts.list[k].f = f[k];
  }
  const auto sp = is_given(sigma) ? numbers_from(sigma, p.size(), "point_sigma")
                                  : std::vector<double>(p.size(), kPointSigma);
  const auto sn = is_given(normal_sigma) ? numbers_from(normal_sigma, p.size(), "normal_sigma")
                                         : std::vector<double>(p.size(), kNormalSigma);
  for (std::size_t k = 0; k < p.size(); ++k) {
    contacts.list[k].point_sigma = sp[k];
    contacts.list[k].normal_sigma = sn[k];
    check_contact(contacts.list[k], k);
    check_stated(contacts.list[k], k);
  }
  return contacts;
}

void check_noise(const char* what, double value, double most) {
  if (value > 0 && value <= most) return;
  throw BadInput(fmt::format("{} is {}, not positive and at most {:.4g}", what, value, most));
}

Rows3 column(const Contacts& contacts, Eigen::Vector3d tactile::Contact::*vector) {
  Rows3 result(static_cast<Eigen::Index>(contacts.list.size()), 3);
  for (Eigen::Index k = 0; k < result.rows(); ++k) {
    result.row(k) = (contacts.list[static_cast<std::size_t>(k)].*vector).transpose();
  }
  return result;
}

Eigen::VectorXd column(const Contacts& contacts, double tactile::Contact::*number) {
  Eigen::VectorXd result(static_cast<Eigen::Index>(contacts.list.size()));
  for (Eigen::Index k = 0; k < result.size(); ++k) {
    result[k] = contacts.list[static_cast<std::size_t>(k)].*number;
  }
  return result;
}

Optional3 normals_of(const Contacts& contacts) {
  const auto known = [](const tactile::Contact& contact) { return contact.has_normal(); };
  if (std::none_of(contacts.list.begin(), contacts.list.end(), known)) return std::nullopt;
  Rows3 result = column(contacts, &tactile::Contact::n);
  for (Eigen::Index k = 0; k < result.rows(); ++k) {
    if (known(contacts.list[static_cast<std::size_t>(k)])) continue;
    result.row(k).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  return result;
}

Eigen::VectorXi groups_of(const Contacts& contacts) {
  Eigen::VectorXi result(static_cast<Eigen::Index>(contacts.list.size()));
  for (Eigen::Index k = 0; k < result.size(); ++k) {
    result[k] = contacts.list[static_cast<std::size_t>(k)].group;
  }
  return result;
}

/// Groups of the second keep apart from those of the first.
Contacts joined(const Contacts& a, const Contacts& b) {
  std::int64_t next = 0;
  for (const auto& contact : a.list) next = std::max<std::int64_t>(next, contact.group + 1LL);
  Contacts both = a;
  for (tactile::Contact contact : b.list) {
    const std::int64_t group = contact.group < 0 ? contact.group : contact.group + next;
    if (group > std::numeric_limits<int>::max()) {
      throw BadInput(
          fmt::format("group {} of the second contacts would be group {}", contact.group, group));
    }
    contact.group = static_cast<int>(group);
    both.list.push_back(contact);
  }
  return both;
}

/// Those that numpy's indexing selects. @throws IndexError as numpy does
Contacts selected(const Contacts& contacts, nb::handle key) {
  const nb::object numpy = nb::module_::import_("numpy");
  const nb::object all = numpy.attr("arange")(contacts.list.size());
  const nb::object chosen = numpy.attr("ravel")(all[key]);
  Contacts result;
  for (const nb::handle index : chosen) {
    result.list.push_back(contacts.list[nb::cast<std::size_t>(nb::int_(index))]);
  }
  return result;
}

Contacts candidates(const Contacts& contacts) {
  Contacts result = contacts;
  for (auto& contact : result.list) contact.group = 0;
  return result;
}

Contacts moved(const Contacts& contacts, nb::handle pose) {
  const Eigen::Isometry3d T = pose_from(pose, "T");
  Contacts result = contacts;
  for (auto& contact : result.list) {
    contact.p = T * contact.p;
    contact.n = T.linear() * contact.n;
    contact.f = T.linear() * contact.f;
  }
  return result;
}

/// For pickle: points, normals (zeros: not known), forces, sigmas, groups.
using State = std::tuple<Rows3, Rows3, Rows3, Eigen::VectorXd, Eigen::VectorXd, Eigen::VectorXi>;

State state_of(const Contacts& contacts) {
  using tactile::Contact;
  return {column(contacts, &Contact::p),
          column(contacts, &Contact::n),
          column(contacts, &Contact::f),
          column(contacts, &Contact::point_sigma),
          column(contacts, &Contact::normal_sigma),
          groups_of(contacts)};
}

/// @throws BadInput for a damaged state
Contacts contacts_of(const State& state) {
  const auto& [p, n, f, point_sigma, normal_sigma, group] = state;
  for (const Eigen::Index count :
       {n.rows(), f.rows(), point_sigma.size(), normal_sigma.size(), group.size()}) {
    if (count != p.rows()) {
      throw BadInput(fmt::format("a state of {} points holds {} values of each", p.rows(), count));
    }
  }
  Contacts contacts{std::vector<tactile::Contact>(static_cast<std::size_t>(p.rows()))};
  for (Eigen::Index k = 0; k < p.rows(); ++k) {
    tactile::Contact& one = contacts.list[static_cast<std::size_t>(k)];
    one.p = p.row(k), one.n = n.row(k), one.f = f.row(k);
    one.point_sigma = point_sigma[k], one.normal_sigma = normal_sigma[k], one.group = group[k];
    check_contact(one, static_cast<std::size_t>(k));
  }
  return contacts;
}

std::string repr(const Contacts& contacts) {
  const auto known = std::count_if(contacts.list.begin(), contacts.list.end(),
                                   [](const auto& contact) { return contact.has_normal(); });
  return fmt::format("Contacts({} points, {} with normals)", contacts.list.size(), known);
}

}  // namespace

void bind_contacts(nb::module_& module) {
  nb::class_<Contacts>(module, "Contacts",
                       "Contacts with an object, from whatever sensor, in one frame.")
      .def(
          "__init__",
          [](Contacts* self, nb::object points, nb::object normals, nb::object forces,
             nb::object point_sigma, nb::object normal_sigma) {
            new (self) Contacts(make_contacts(points, normals, forces, point_sigma, normal_sigma));
          },
          "points"_a, "normals"_a = nb::none(), "forces"_a = nb::none(),
          "point_sigma"_a = nb::none(), "normal_sigma"_a = nb::none(),
          nb::sig("def __init__(self, points: numpy.typing.ArrayLike, normals: "
                  "numpy.typing.ArrayLike | None = None, forces: numpy.typing.ArrayLike | None = "
                  "None, point_sigma: numpy.typing.ArrayLike | None = None, normal_sigma: "
                  "numpy.typing.ArrayLike | None = None) -> None"),
          "Contacts at points (N, 3), m.\n\nnormals (N, 3): outward of the object, made unit "
          "vectors; a row of nan: not known. forces (N, 3): of the sensor on the object, N. "
          "point_sigma: error per axis, m, one number or (N,), 0.001 if not given, at most 0.1. "
          "normal_sigma: per tangent axis, rad, 10 deg if not given, at most pi/2.\n\nRaises "
          "ValueError, naming the contact, for other shapes, values that are not finite, and "
          "sigmas that are not positive or too large.")
      .def("__len__", [](const Contacts& self) { return self.list.size(); })
      .def_prop_ro(
          "points", [](const Contacts& self) { return column(self, &tactile::Contact::p); },
          "(N, 3), m.")
      .def_prop_ro("normals", &normals_of,
                   "Outward of the object, (N, 3), nan where not known; None if none is known.")
      .def_prop_ro(
          "forces", [](const Contacts& self) { return column(self, &tactile::Contact::f); },
          "Of the sensor on the object, (N, 3), N.")
      .def_prop_ro(
          "point_sigma",
          [](const Contacts& self) { return column(self, &tactile::Contact::point_sigma); },
          "Per axis, (N,), m.")
      .def_prop_ro(
          "normal_sigma",
          [](const Contacts& self) { return column(self, &tactile::Contact::normal_sigma); },
          "Per tangent axis, (N,), rad.")
      .def_prop_ro("groups", &groups_of,
                   "(N,); -1: the contact touches; else at least one of its group does.")
      .def("candidates", &candidates, "The same points as one group of which at least one touches.")
      .def("transformed", &moved, "T"_a,
           nb::sig("def transformed(self, T: numpy.typing.ArrayLike) -> Contacts"),
           "Moved by T_new_old (4, 4).\n\nRaises ValueError unless T is a rigid motion.")
      .def("__getitem__", &selected, "key"_a,
           nb::sig("def __getitem__(self, key: typing.Any) -> Contacts"),
           "Those of an index, a slice, or an array of indices or truths, as of a numpy array.")
      .def("__add__", &joined, "other"_a)
      .def("__getstate__", &state_of)
      .def("__setstate__",
           [](Contacts* self, const State& state) { new (self) Contacts(contacts_of(state)); })
      .def("__repr__", &repr);
  module.def(
      "read_contacts",
      [](const std::filesystem::path& path, double point_sigma, double normal_sigma) {
        check_noise("point_sigma", point_sigma, localization::kMaxPointSigma);
        check_noise("normal_sigma", normal_sigma, std::numbers::pi / 2);
        return Contacts{localization::read_contacts(path, {point_sigma, normal_sigma})};
      },
      "path"_a, nb::kw_only(), "point_sigma"_a = kPointSigma, "normal_sigma"_a = kNormalSigma,
      nb::call_guard<WithoutGil>(),
      "Contacts of a CSV with x,y,z and, optionally, nx,ny,nz,point_sigma,normal_sigma,"
      "group,finger,t,fx,fy,fz; point_sigma (m) and normal_sigma (rad) where the file states "
      "none.\n\nRaises ValueError, naming file and line, and for noise that is not positive or "
      "too large.");
}

}  // namespace palpate::python
