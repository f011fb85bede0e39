// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>

#include "libraries.hpp"
#include "palpate/localization/pose_prior.hpp"
#include "pickle.hpp"
#include "shared_model.hpp"

namespace palpate::python {

/// A prior with the name of the object whose pose it is of.
struct PosePrior {
  localization::PosePrior prior;
  std::string object;
};

/// @throws BadInput for what is of another object
inline void require_same_name(const char* what, const std::string& other, const std::string& mine) {
  if (mine != other) throw BadInput(fmt::format("the {} is of '{}', not '{}'", what, other, mine));
}

// What pickles keep of posteriors and evidence.

template <>
struct Fields<localization::FreeAxis> {
  static auto of(localization::FreeAxis& it) {
    return std::tie(it.point, it.direction, it.extent, it.share);
  }
  static void check(const localization::FreeAxis& it) {
    if (it.extent >= 0 && it.extent <= 2 * std::numbers::pi) return;
    throw BadInput(fmt::format("a free axis of +- {} rad", it.extent));
  }
};
template <>
struct Fields<localization::Mode> {
  static auto of(localization::Mode& it) {
    return std::tie(it.T_frame_object, it.weight, it.covariance, it.free_axis);
  }
  static void check(const localization::Mode& it) {
    if (it.weight >= 0 && std::isfinite(it.weight)) return;
    throw BadInput(fmt::format("a mode of weight {}", it.weight));
  }
};
template <>
struct Fields<Mode> {
  static auto of(Mode& it) { return std::tie(it.mode, it.T_object_mesh); }
};
template <>
struct Fields<localization::Posterior> {
  static auto of(localization::Posterior& it) {
    return std::tie(it.status, it.modes, it.residual_set, it.credible_mass, it.seconds);
  }
};
template <>
struct Fields<localization::PosePrior::Component> {
  static auto of(localization::PosePrior::Component& it) {
    return std::tie(it.T_frame_object, it.weight, it.covariance);
  }
};
template <>
struct Fields<localization::PosePrior> {
  static auto of(localization::PosePrior& it) { return std::tie(it.components, it.floor); }
};
template <>
struct Fields<PosePrior> {
  static auto of(PosePrior& it) { return std::tie(it.prior, it.object); }
};
template <>
struct Fields<localization::TableSupport> {
  static auto of(localization::TableSupport& it) {
    return std::tie(it.T_frame_table, it.stable_pose_weights, it.tilt_sigma, it.height_sigma,
                    it.surface_sigma, it.centroid_sigma, it.half_width, it.edge_sigma);
  }
};

/// With the model, which pickle keeps once for all posteriors of it.
template <>
struct Kept<Posterior> {
  static nb::object of(const Posterior& posterior) {
    auto model = std::const_pointer_cast<geometry::ObjectModel>(posterior.model);
    return nb::make_tuple(Kept<localization::Posterior>::of(posterior.found),
                          nb::cast(std::move(model)));
  }
  static void into(nb::handle kept, Posterior& posterior) {
    const auto [found, model] = nb::cast<std::tuple<nb::object, nb::object>>(kept);
    Kept<localization::Posterior>::into(found, posterior.found);
    posterior.model = model_from(model);
  }
};

}  // namespace palpate::python
