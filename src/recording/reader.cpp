// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/plausible.hpp"
#include "palpate/recording/json_text.hpp"
#include "palpate/tactile/contacts/reported_error.hpp"
#include "recording/hdf5_file.hpp"
#include "recording/record_json.hpp"
#include "recording/schema.hpp"
#include "recording/seal.hpp"

namespace palpate::recording {
namespace {

/// Whether the contacts report their errors: from version 4 on the header says so.
bool has_errors(const Seal& seal, const RecordingHeader& header) {
  constexpr int kErrorsByVersion = 3;
  return seal.version == kErrorsByVersion ||
         (seal.version > kErrorsByVersion && header.sensor_reported_errors);
}

/// A dataset of text, one record a line; a last line without its end was never wholly written.
template <class Record>
std::vector<Record> read_lines(const H5::H5File& file, const char* name,
                               Record (*from_json)(const nlohmann::json&)) {
  const std::vector<char> text = read_rows<char>(file, name, 1);
  std::vector<Record> records;
  auto line = text.begin();
  for (auto end = line; (end = std::find(line, text.end(), '\n')) != text.end(); line = end + 1) {
    records.push_back(from_json(parse_json({line, end})));
  }
  return records;
}

geometry::TriangleMesh read_mesh(const H5::H5File& file) {
  geometry::TriangleMesh mesh;
  const auto vertices = read_rows<double>(file, kVertices, 3);
  const auto triangles = read_rows<int>(file, kTriangles, 3);
  for (std::size_t i = 0; i < vertices.size(); i += 3) {
    mesh.vertices.emplace_back(vertices[i], vertices[i + 1], vertices[i + 2]);
    check_plausible(mesh.vertices.back(), kMaxLength, "a coordinate of the mesh");
  }
  const int count = static_cast<int>(mesh.vertices.size());
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    const std::array<int, 3> t = {triangles[i], triangles[i + 1], triangles[i + 2]};
    for (const int v : t) {
      if (v < 0 || v >= count) throw BadInput(fmt::format("the mesh has no vertex {}", v));
    }
    mesh.triangles.push_back(t);
  }
  return mesh;
}

RecordingHeader read_header(const H5::H5File& file) {
  const std::vector<char> text = read_rows<char>(file, kHeaderText, 1);
  RecordingHeader header = header_from_json(parse_json({text.begin(), text.end()}));
  header.object.mesh = read_mesh(file);
  return header;
}

/// Number of leading frames whose contacts are all there.
std::size_t complete_frames(const std::vector<int>& counts, std::size_t fingers,
                            std::size_t contacts) {
  std::size_t frames = 0, used = 0;
  for (; (frames + 1) * fingers <= counts.size(); ++frames) {
    for (std::size_t finger = 0; finger < fingers; ++finger) {
      const int count = counts[frames * fingers + finger];
      if (count < 0) throw BadInput(fmt::format("frame {} has {} contacts", frames, count));
      used += static_cast<std::size_t>(count);
    }
    if (used > contacts) break;
  }
  return frames;
}

/// @throws BadInput unless the contacts' rows can be what a fingertip met
void check_contacts(const std::vector<double>& rows) {
  for (std::size_t i = 0; i + kContactWidth <= rows.size(); i += kContactWidth) {
    constexpr double kUnit = 1e-3;
    const Eigen::Map<const Eigen::Vector3d> p(&rows[i]), n(&rows[i + 3]), f(&rows[i + 6]);
    check_plausible(p, kMaxLength, "a contact's coordinate");
    plausible(n.norm(), 1 - kUnit, 1 + kUnit, "the length of a contact's normal");
    check_plausible(f, kMaxForce, "a contact's force");
  }
}

void check_finite(const std::vector<double>& values, const char* name, int width) {
  const auto bad = std::find_if(values.begin(), values.end(),
                                [](double value) { return !std::isfinite(value); });
  if (bad == values.end()) return;
  throw BadInput(
      fmt::format("{} of frame {} holds {}", name, (bad - values.begin()) / width, *bad));
}

/// @param errors  of the contacts; empty where they report none
void set_contacts(const std::vector<int>& counts, const std::vector<double>& rows,
                  const std::vector<double>& errors, std::vector<Frame>& frames) {
  const double* row = rows.data();
  const double* error = errors.data();
  std::size_t k = 0;
  for (Frame& frame : frames) {
    for (auto& finger : frame.reading.contacts) {
      for (int i = counts[k++]; i > 0; --i, row += kContactWidth) {
        using Eigen::Vector3d;
        finger.push_back({Vector3d(row), Vector3d(row + 3), Vector3d(row + 6)});
        if (errors.empty()) continue;
        finger.back().point_sigma = *error++;
        finger.back().normal_sigma = *error++;
      }
    }
  }
}

/// The errors that the contacts report; empty where they report none.
std::vector<double> read_contact_errors(const H5::H5File& file) {
  auto errors = read_rows<double>(file, kContactErrors, kContactErrorWidth);
  const auto bad = std::find_if_not(errors.begin(), errors.end(), tactile::is_standard_deviation);
  if (bad == errors.end()) return errors;
  throw BadInput(fmt::format("{} of contact {} holds {}", kContactErrors,
                             (bad - errors.begin()) / kContactErrorWidth, *bad));
}

/// The counts of the BioTacs; empty where the fingertips have none.
std::vector<std::int16_t> read_biotacs(const H5::H5File& file, const Seal& seal, hsize_t width) {
  constexpr int kFirstVersionWithBiotacs = 2;
  if (seal.version < kFirstVersionWithBiotacs) return {};
  return read_rows<std::int16_t>(file, kBiotacs, width);
}

std::vector<Frame> read_frames(const H5::H5File& file, const Seal& seal,
                               const RecordingHeader& header) {
  const hand::Description& hand = header.hand;
  const bool sensor_reported_errors = has_errors(seal, header);
  const std::size_t fingers = hand.fingers.size();
  const auto fields = frame_fields(hand);
  const auto counts = read_rows<int>(file, kContactCounts, fingers);
  const auto contacts = read_rows<double>(file, kContacts, kContactWidth);
  check_finite(contacts, kContacts, kContactWidth);
  check_contacts(contacts);
  const auto errors = sensor_reported_errors ? read_contact_errors(file) : std::vector<double>{};
  std::size_t whole = contacts.size() / kContactWidth;
  if (sensor_reported_errors) {
    whole = std::min(whole, errors.size() / kContactErrorWidth);
  }
  std::size_t frames = complete_frames(counts, fingers, whole);
  std::size_t longest = counts.size() / fingers;
  std::vector<std::vector<double>> columns;
  for (const FrameField& field : fields) {
    const auto width = static_cast<hsize_t>(field.width);
    columns.push_back(read_rows<double>(file, field.name, width));
    if (!field.may_be_absent) check_finite(columns.back(), field.name, field.width);
    frames = std::min<std::size_t>(frames, columns.back().size() / width);
    longest = std::max<std::size_t>(longest, columns.back().size() / width);
  }
  const std::size_t biotacs_width = fingers * kBiotacWidth;
  const auto biotacs = read_biotacs(file, seal, biotacs_width);
  if (!biotacs.empty()) {
    frames = std::min<std::size_t>(frames, biotacs.size() / biotacs_width);
    longest = std::max<std::size_t>(longest, biotacs.size() / biotacs_width);
  }
  if (seal.finished && frames != longest) {
    throw BadInput(fmt::format("only {} of {} frames are whole", frames, longest));
  }
  std::vector<Frame> result(frames, empty_frame(hand));
  for (std::size_t f = 0; f < columns.size(); ++f) {
    const FrameField& field = fields[f];
    const auto width = static_cast<std::size_t>(field.width);
    for (std::size_t i = 0; i < frames; ++i) {
      check_plausible(Eigen::Map<const Eigen::VectorXd>(&columns[f][i * width], field.width),
                      field.most, field.name, field.may_be_absent);
      field.set(&columns[f][i * width], result[i]);
    }
  }
  set_contacts(counts, contacts, errors, result);
  for (std::size_t i = 0; i < frames && !biotacs.empty(); ++i) {
    set_biotacs(&biotacs[i * biotacs_width], result[i].reading);
  }
  return result;
}

Recording read_contents(const std::filesystem::path& path, const Seal& seal) {
  const unsigned access = seal.finished ? H5F_ACC_RDONLY : H5F_ACC_RDONLY | H5F_ACC_SWMR_READ;
  const H5::H5File file(path.string(), access, H5::FileCreatPropList::DEFAULT, file_access());
  RecordingHeader header = read_header(file);
  auto frames = read_frames(file, seal, header);
  return {.header = std::move(header),
          .frames = std::move(frames),
          .events = read_lines(file, kEvents, &event_from_json),
          .estimates = read_lines(file, kEstimates, &estimate_from_json),
          .beliefs = file.nameExists("beliefs") ? read_lines(file, kBeliefs, &belief_from_json)
                                                : std::vector<BeliefRecord>{},
          .finished = seal.finished};
}

}  // namespace

Recording read_recording(const std::filesystem::path& path) {
  const Seal seal = check_seal(path);
  return with_hdf5(path, "damaged", [&] {
    try {
      return read_contents(path, seal);
    } catch (const nlohmann::json::exception& error) {
      throw BadInput(fmt::format("{}: damaged: {}", path.string(), error.what()));
    } catch (const BadInput& error) {
      throw BadInput(fmt::format("{}: damaged: {}", path.string(), error.what()));
    }
  });
}

}  // namespace palpate::recording
