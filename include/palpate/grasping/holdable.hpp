// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "palpate/geometry/objects/object_model.hpp"
#include "palpate/hand/description.hpp"

namespace palpate::grasping {

/// m between the thumb's tip and the farthest other fingertip, surface to surface, in the widest of
/// the postures from which the hand closes.
double opening(const hand::Description& hand);

/// N of all fingertips together, with which the thumb and the other fingers can press against one
/// another: each finger by the weakest of its closing actuators (torque over lever).
double greatest_press(const hand::Description& hand);

/// m, the least distance through an object that lies on the table, from a point of its surface that
/// looks more to the side than up or down to the opposite one along the normal, over all stable
/// poses.
double min_width(const geometry::KnownObject& object);

/// Why a hand cannot hold an object, wherever it grasps it from above.
///
/// Too wide: it is wider than half the hand's opening, and in no stable pose there is a place where
/// the opened hand comes down beside it and the fingers' forces then balance any of its weight
/// (GraspPlan::cost below 1, or below 0.5 where they press harder than by default). Too heavy: it
/// weighs more than the fingers bear by a friction of 1.
///
/// @param press  N of all fingertips together, with which the object would be held; no more than
///   greatest_press() is counted on, and no less than GraspPlanOptions::press
/// @return empty if it may hold it
/// @throws BadInput for a hand without links
std::string why_not_holdable(const geometry::ObjectModel& object, const hand::Description& hand,
                             double press);

}  // namespace palpate::grasping
