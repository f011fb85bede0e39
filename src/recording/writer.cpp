// SPDX-License-Identifier: Apache-2.0
#include "palpate/recording/writer.hpp"

#include <fmt/format.h>

#include <map>
#include <optional>

#include "palpate/core/durable_file.hpp"
#include "palpate/tactile/contacts/reported_error.hpp"
#include "recording/hdf5_file.hpp"
#include "recording/record_json.hpp"
#include "recording/schema.hpp"
#include "recording/seal.hpp"

namespace palpate::recording {
namespace {

constexpr hsize_t kTextChunk = 4096, kContactsPerChunk = 512, kMeshRowsPerChunk = 4096;

constexpr const char* kCannotWrite = "cannot be written";

/// Text of JSON that any reader accepts: bytes that are not UTF-8 are replaced.
std::string dump(const nlohmann::json& value) {
  return value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void append_text(hid_t file, const char* name, const std::string& text) {
  append_rows(file, name, text.data(), text.size(), 1, native_type<char>());
}

/// @throws BadInput if what will be in the file could not be read back
void check_readable(const RecordingHeader& header) {
  try {
    header_from_json(to_json(header));
  } catch (const nlohmann::json::exception& error) {
    throw BadInput(fmt::format("header of a recording: {}", error.what()));
  }
}

void check_readable(const EstimateRecord& estimate) {
  try {
    estimate_from_json(to_json(estimate));
  } catch (const nlohmann::json::exception& error) {
    throw BadInput(fmt::format("estimate at {} s: {}", estimate.time, error.what()));
  }
}

void check_readable(const BeliefRecord& belief) {
  try {
    belief_from_json(to_json(belief));
  } catch (const nlohmann::json::exception& error) {
    throw BadInput(fmt::format("belief at {} s: {}", belief.time, error.what()));
  }
}

void write_mesh(hid_t file, const geometry::TriangleMesh& mesh) {
  std::vector<double> vertices;
  std::vector<int> triangles;
  for (const auto& vertex : mesh.vertices) {
    vertices.insert(vertices.end(), vertex.data(), vertex.data() + 3);
  }
  for (const auto& t : mesh.triangles) triangles.insert(triangles.end(), t.begin(), t.end());
  append_rows(file, kVertices, vertices.data(), mesh.vertices.size(), 3, native_type<double>());
  append_rows(file, kTriangles, triangles.data(), mesh.triangles.size(), 3, native_type<int>());
}

void create_datasets(hid_t file, const hand::Description& hand, bool sensor_reported_errors) {
  for (const char* group : {"header", "frames", "events", "estimates", "beliefs"})
    create_group(file, group);
  for (const char* text : {kHeaderText, kEvents, kEstimates, kBeliefs}) {
    create_growing(file, text, hdf5_type<char>(), 1, kTextChunk);
  }
  create_growing(file, kVertices, hdf5_type<double>(), 3, kMeshRowsPerChunk);
  create_growing(file, kTriangles, hdf5_type<int>(), 3, kMeshRowsPerChunk);
  for (const FrameField& field : frame_fields(hand)) {
    create_growing(file, field.name, hdf5_type<double>(), static_cast<hsize_t>(field.width),
                   kFramesPerChunk);
  }
  create_growing(file, kContactCounts, hdf5_type<int>(), hand.fingers.size(), kFramesPerChunk);
  create_growing(file, kContacts, hdf5_type<double>(), kContactWidth, kContactsPerChunk);
  if (sensor_reported_errors) {
    create_growing(file, kContactErrors, hdf5_type<double>(), kContactErrorWidth,
                   kContactsPerChunk);
  }
  create_growing(file, kBiotacs, hdf5_type<std::int16_t>(), hand.fingers.size() * kBiotacWidth,
                 kFramesPerChunk);
}

/// The file with everything that does not grow, closed again.
void create_file(const std::filesystem::path& path, const RecordingHeader& header) {
  H5::FileCreatPropList properties;
  properties.setUserblock(kSealSize);
  H5Pset_obj_track_times(properties.getId(), false);  // of the root group
  const Handle file(
      H5Fcreate(path.c_str(), H5F_ACC_TRUNC, properties.getId(), file_access().getId()), &H5Fclose);
  create_datasets(file, header.hand, header.sensor_reported_errors);
  append_text(file, kHeaderText, dump(to_json(header)));
  write_mesh(file, header.object.mesh);
}

/// @throws BadInput unless the frame's values are of the hand's sizes
void check_sizes(const Frame& frame, const hand::Description& hand) {
  const hand::HandReading& reading = frame.reading;
  if (reading.joints.size() == hand.joint_count() &&
      reading.torques.size() == hand.actuator_count() &&
      frame.command.positions.size() == hand.actuator_count() &&
      reading.contacts.size() == hand.fingers.size()) {
    return;
  }
  throw BadInput(fmt::format(
      "the frame at {} s has {} joints, {} torques, {} commands and {} fingertips, the hand {} "
      "joints, {} actuators and {} fingers",
      reading.time, reading.joints.size(), reading.torques.size(), frame.command.positions.size(),
      reading.contacts.size(), hand.joint_count(), hand.actuator_count(), hand.fingers.size()));
}

/// @throws BadInput if a contact reports its error, which the file has no place for
void check_silent(const hand::HandReading& reading) {
  for (const auto& finger : reading.contacts) {
    for (const auto& contact : finger) {
      if (contact.point_sigma == 0 && contact.normal_sigma == 0) continue;
      throw BadInput(fmt::format(
          "a contact of the frame at {} s reports the uncertainty {} m and {} rad, which "
          "the header does not announce",
          reading.time, contact.point_sigma, contact.normal_sigma));
    }
  }
}

/// @throws BadInput if a contact reports an error that cannot be one
void check_errors(const hand::HandReading& reading) {
  for (const auto& finger : reading.contacts) {
    for (const auto& contact : finger) {
      if (tactile::has_valid_errors(contact)) continue;
      throw BadInput(fmt::format(
          "a contact of the frame at {} s has the errors {} m and {} rad: not finite or negative",
          reading.time, contact.point_sigma, contact.normal_sigma));
    }
  }
}

void append_contact(const hand::TipContact& contact, std::vector<double>& rows) {
  for (const Eigen::Vector3d* v : {&contact.p, &contact.n, &contact.f}) {
    rows.insert(rows.end(), v->data(), v->data() + 3);
  }
}

}  // namespace

struct Writer::Impl {
  std::filesystem::path path, partial;
  bool sensor_reported_errors = false;
  hand::Description hand;
  std::size_t fingers = 0;
  std::vector<FrameField> fields;
  std::optional<Handle> file;
  std::vector<Frame> pending;          // until a chunk is full: chunks are then written once
  std::vector<std::int16_t> channels;  // of the BioTacs in those
  std::optional<bool> has_channels;    // whether the frames hold any
  bool broken = false;                 // something could not be written: never to be sealed

  /// Runs body() in HDF5. @throws BadInput if it fails, or anything failed before
  template <class Body>
  void write(Body&& body) {
    if (broken) {
      throw BadInput(
          fmt::format("{}: not finished: a part of it could not be written", partial.string()));
    }
    broken = true;
    with_hdf5(partial, kCannotWrite, body);
    broken = false;
  }

  void flush() { expect_done(H5Fflush(*file, H5F_SCOPE_GLOBAL), "H5Fflush"); }

  void append(const char* name, const std::vector<double>& values, int width) {
    append_rows(*file, name, values.data(), values.size() / static_cast<std::size_t>(width),
                static_cast<hsize_t>(width), native_type<double>());
  }

  void append_contacts() {
    std::vector<int> counts;
    std::vector<double> rows, errors;
    for (const Frame& frame : pending) {
      for (const auto& finger : frame.reading.contacts) {
        counts.push_back(static_cast<int>(finger.size()));
        for (const auto& contact : finger) {
          append_contact(contact, rows);
          errors.insert(errors.end(), {contact.point_sigma, contact.normal_sigma});
        }
      }
    }
    append(kContacts, rows, kContactWidth);
    if (sensor_reported_errors) append(kContactErrors, errors, kContactErrorWidth);
    append_rows(*file, kContactCounts, counts.data(), pending.size(), fingers, native_type<int>());
  }

  void append_channels() {
    append_rows(*file, kBiotacs, channels.data(), channels.size() / (fingers * kBiotacWidth),
                fingers * kBiotacWidth, native_type<std::int16_t>());
    channels.clear();
  }

  void write_pending() {
    if (pending.empty()) return;
    // These first: a frame that a reader finds then always has its contacts and channels.
    append_contacts();
    append_channels();
    flush();
    for (const FrameField& field : fields) {
      const auto width = static_cast<std::size_t>(field.width);
      std::vector<double> values(pending.size() * width);
      for (std::size_t i = 0; i < pending.size(); ++i) field.get(pending[i], &values[i * width]);
      append(field.name, values, field.width);
    }
    flush();
    pending.clear();
  }

  void append_line(const char* dataset, const nlohmann::json& json) {
    write([&] {
      append_text(*file, dataset, dump(json) + "\n");
      flush();
    });
  }
};

Writer::Writer(std::filesystem::path path, const RecordingHeader& header) : impl_(new Impl) {
  impl_->sensor_reported_errors = header.sensor_reported_errors;
  impl_->hand = header.hand;
  impl_->fingers = header.hand.fingers.size();
  impl_->fields = frame_fields(header.hand);
  impl_->path = std::move(path);
  impl_->partial = impl_->path.string() + ".partial";
  check_readable(header);
  std::error_code error;
  if (std::filesystem::is_directory(impl_->path, error)) {
    throw BadInput(fmt::format("{}: a folder, not a file to write", impl_->path.string()));
  }
  with_hdf5(impl_->partial, kCannotWrite, [&] { create_file(impl_->partial, header); });
  write_open_seal(impl_->partial, kFormatVersion);
  with_hdf5(impl_->partial, kCannotWrite, [&] {
    impl_->file.emplace(
        H5Fopen(impl_->partial.c_str(), H5F_ACC_RDWR | H5F_ACC_SWMR_WRITE, file_access().getId()),
        &H5Fclose);
  });
}

Writer::~Writer() {
  if (!impl_->file) return;
  const auto attempt = [&](auto&& body) {
    try {
      with_hdf5(impl_->partial, kCannotWrite, body);
    } catch (const BadInput&) {
      // The disk is full or gone; what was flushed before remains, and is not sealed.
    }
  };
  if (!impl_->broken) attempt([&] { impl_->write_pending(); });
  attempt([&] { impl_->file.reset(); });
}

void Writer::frame(const Frame& frame) {
  check_sizes(frame, impl_->hand);
  const bool has_channels = !frame.reading.biotacs.empty();
  if (impl_->has_channels.value_or(has_channels) != has_channels) {
    throw BadInput(fmt::format("the frame at {} s {} channels of BioTacs, unlike those before it",
                               frame.reading.time, has_channels ? "has" : "lacks"));
  }
  impl_->has_channels = has_channels;
  if (impl_->sensor_reported_errors) {
    check_errors(frame.reading);
  } else {
    check_silent(frame.reading);
  }
  if (has_channels) append_biotacs(frame.reading, impl_->channels);
  impl_->pending.push_back(frame);
  if (impl_->pending.size() < kFramesPerChunk) return;
  impl_->write([&] { impl_->write_pending(); });
}

void Writer::event(const Event& event) { impl_->append_line(kEvents, to_json(event)); }

void Writer::estimate(const EstimateRecord& estimate) {
  check_readable(estimate);
  impl_->append_line(kEstimates, to_json(estimate));
}

void Writer::belief(const BeliefRecord& belief) {
  check_readable(belief);
  impl_->append_line(kBeliefs, to_json(belief));
}

void Writer::finish() {
  impl_->write([&] {
    impl_->write_pending();
    impl_->file.reset();
  });
  write_closed_seal(impl_->partial, kFormatVersion);
  publish_file(impl_->partial, impl_->path);
}

void write_recording(const std::filesystem::path& path, const Recording& recording) {
  Writer writer(path, recording.header);
  for (const auto& frame : recording.frames) writer.frame(frame);
  for (const auto& event : recording.events) writer.event(event);
  for (const auto& estimate : recording.estimates) writer.estimate(estimate);
  for (const auto& belief : recording.beliefs) writer.belief(belief);
  writer.finish();
}

}  // namespace palpate::recording
