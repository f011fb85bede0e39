// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/hand_spec.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <limits>

#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/spelling.hpp"
#include "palpate/geometry/query/rounded_hull.hpp"
#include "simulation/hand/hand_alone.hpp"
#include "simulation/hand/link_masses.hpp"
#include "simulation/hand/mesh_files.hpp"
#include "simulation/hand/urdf.hpp"
#include "simulation/hand/warnings.hpp"
#include "simulation/hand/xml_tags.hpp"

namespace palpate::simulation {
namespace {

/// Geoms of a body that collide.
std::vector<mjsGeom*> solids(mjsBody& body) {
  std::vector<mjsGeom*> result;
  for (mjsElement* e = mjs_firstChild(&body, mjOBJ_GEOM, 0); e; e = mjs_nextChild(&body, e, 0)) {
    mjsGeom* geom = mjs_asGeom(e);
    if (geom->contype != 0 || geom->conaffinity != 0) result.push_back(geom);
  }
  return result;
}

bool is_control(char c) { return static_cast<unsigned char>(c) < ' '; }

/// Gives free names to what has none, so that it can be found again.
/// @throws BadInput for one that a terminal would not print
void name_all(mjSpec& spec, mjtObj type, const char* kind) {
  int count = 0;
  for (mjsElement* e = mjs_firstElement(&spec, type); e; e = mjs_nextElement(&spec, e), ++count) {
    const std::string given = mjs_getString(mjs_getName(e));
    if (std::ranges::any_of(given, is_control)) {
      throw BadInput(fmt::format("the name of a {} has control characters", kind));
    }
    if (!given.empty()) continue;
    std::string name = fmt::format("{}_{}", kind, count);
    while (mjs_findElement(&spec, type, name.c_str())) name += '_';
    set_name(e, name);
  }
}

void remove_all(mjSpec& spec, mjtObj type) {
  while (mjsElement* element = mjs_firstElement(&spec, type)) mjs_delete(&spec, element);
}

/// A floor or a table of the file's own.
void remove_surroundings(mjSpec& spec) {
  mjsBody* world = mjs_findBody(&spec, "world");
  while (mjsElement* geom = mjs_firstChild(world, mjOBJ_GEOM, 0)) mjs_delete(&spec, geom);
}

/// What is added to the model from now on is not of the file's own making. What is in it keeps the
/// defaults that it was read with.
void forget_defaults(mjSpec& spec) {
  mjsDefault& defaults = *mjs_getSpecDefault(&spec);
  mjs_defaultGeom(defaults.geom);
  mjs_defaultJoint(defaults.joint);
  mjs_defaultMesh(defaults.mesh);
  mjs_defaultPair(defaults.pair);
  mjs_defaultEquality(defaults.equality);
  mjs_defaultTendon(defaults.tendon);
  mjs_defaultActuator(defaults.actuator);
}

/// A file may ask for any amount of memory; nothing here needs what it asks for.
void forget_sizes(mjSpec& spec) {
  spec.memory = -1;
  spec.njmax = spec.nconmax = -1;
  spec.nstack = -1;
  spec.nuserdata = 0;
  for (int* numbers :
       {&spec.nuser_body, &spec.nuser_jnt, &spec.nuser_geom, &spec.nuser_site, &spec.nuser_cam,
        &spec.nuser_tendon, &spec.nuser_actuator, &spec.nuser_sensor}) {
    *numbers = -1;  // as many as its elements have
  }
}

/// How far the middle of a geom is from a point of its body.
double distance_to(const mjsGeom& geom, const Eigen::Vector3d& p) {
  return (middle_in_body(geom) - p).norm();
}

/// Pairs of geoms that may touch name them.
void rename_geom(mjSpec& spec, mjsGeom& geom, const std::string& name) {
  const std::string before = mjs_getString(mjs_getName(geom.element));
  set_name(geom.element, name);
  for (mjsElement* e = mjs_firstElement(&spec, mjOBJ_PAIR); e; e = mjs_nextElement(&spec, e)) {
    mjsPair& pair = *mjs_asPair(e);
    for (mjString* geom_name : {pair.geomname1, pair.geomname2}) {
      if (mjs_getString(geom_name) == before) mjs_setString(geom_name, name.c_str());
    }
  }
}

/// Orientation (w, x, y, z) that turns z into the direction of a capsule's axis.
Eigen::Vector4d orientation(const Eigen::Vector3d& axis) {
  if (axis.head<2>().isZero() && axis.z() >= 0) return {1, 0, 0, 0};
  const auto q = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis);
  return {q.w(), q.x(), q.y(), q.z()};
}

void become_capsule(mjsGeom& geom, const hand::TipCapsule& capsule) {
  const Eigen::Vector3d axis = capsule.b - capsule.a;
  geom.type = mjGEOM_CAPSULE;
  mjs_setString(geom.meshname, "");
  Eigen::Vector3d::Map(geom.size) << capsule.radius, 0.5 * axis.norm(), 0;
  Eigen::Vector3d::Map(geom.pos) = 0.5 * (capsule.b + capsule.a);
  Eigen::Vector4d::Map(geom.quat) = orientation(axis);
}

/// What meets other things than objects and tables is the polytope within the rounded edges.
void become_hull(mjSpec& spec, mjsGeom& geom, const std::string& name, const hand::TipHull& hull) {
  std::vector<float> vertices;
  for (const auto& p : geometry::RoundedHull(hull.core, hull.radius).surface_points()) {
    for (const double value : p) vertices.push_back(static_cast<float>(value));
  }
  const std::string asset = name + ".hull";
  mjsMesh* mesh = mjs_addMesh(&spec, nullptr);
  set_name(mesh->element, asset);
  mjs_setFloat(mesh->uservert, vertices.data(), static_cast<int>(vertices.size()));
  Eigen::Vector3d::Map(mesh->scale).setOnes();
  geom.type = mjGEOM_MESH;
  mjs_setString(geom.meshname, asset.c_str());
  Eigen::Vector3d::Map(geom.pos).setZero();
  Eigen::Vector4d::Map(geom.quat) << 1, 0, 0, 0;
}

/// What MuJoCo says, shortened where the file is not XML at all.
std::string reason_of(const std::string& message) {
  if (message.find("Unrecognized XML model type") != message.npos) {
    return "its first element is neither <mujoco> nor <robot>: MJCF or URDF is needed";
  }
  if (!message.starts_with("XML parse error")) return message;
  const auto line = message.find("Line number=");
  if (line == message.npos) return "it is not XML";
  return fmt::format("it is not XML, from line {} on", std::atoi(message.c_str() + line + 12));
}

/// Leaves of the file the bodies of hands, all with names, and nothing that reaches beyond them.
void clean(mjSpec& spec) {
  mj_defaultOption(&spec.option);  // gravity, the solver and what it leaves out
  spec.authored = {};
  spec.compiler.fusestatic = 0;      // of a URDF: every link stays a body
  spec.compiler.balanceinertia = 1;  // those of drawings often break A + B >= C
  apply_inertia_rules(spec);
  remove_all(spec, mjOBJ_KEY);     // of other numbers of joints than a scene's
  remove_all(spec, mjOBJ_SENSOR);  // of actuators that are replaced
  remove_all(spec, mjOBJ_TUPLE);   // of what may go
  remove_all(spec, mjOBJ_SKIN);
  remove_surroundings(spec);
  forget_defaults(spec);
  forget_sizes(spec);
  name_all(spec, mjOBJ_BODY, "body");
  name_all(spec, mjOBJ_JOINT, "joint");
}

/// What a function returns. @throws BadInput with what it throws after the file's name
template <class Function>
auto naming(const std::filesystem::path& file, std::string_view kind, const Function& function) {
  try {
    return function();
  } catch (const BadInput& error) {
    throw BadInput(fmt::format("cannot read the {} {}: {}", kind, file.string(), error.what()));
  }
}

/// The files of meshes that a URDF's text names otherwise.
void restore_files(mjSpec& spec, const Urdf& urdf) {
  for (mjsElement* e = mjs_firstElement(&spec, mjOBJ_MESH); e; e = mjs_nextElement(&spec, e)) {
    mjsMesh& mesh = *mjs_asMesh(e);
    const auto file =
        urdf.meshes.find(std::filesystem::path(mjs_getString(mesh.file)).stem().string());
    if (file != urdf.meshes.end()) mjs_setString(mesh.file, file->second.c_str());
  }
}

using Message = std::array<char, 1000>;

/// Null if the simulator does not understand it, as the file has it or as it is put right.
SpecHandle parse_urdf(const std::filesystem::path& file, Message& message) {
  const Urdf urdf = read_urdf(file);
  {
    const Warnings of_file;  // are those of the text, too
    const SpecHandle as_it_is(
        mj_parseXML(file.c_str(), nullptr, message.data(), static_cast<int>(message.size())));
    if (!as_it_is) return SpecHandle();
  }
  SpecHandle spec(mj_parseXMLString(urdf.text.c_str(), nullptr, message.data(),
                                    static_cast<int>(message.size())));
  if (!spec) return spec;
  mjs_setString(spec->modelfiledir, (file.parent_path() / "").c_str());
  restore_files(*spec, urdf);
  return spec;
}

SpecHandle read_xml(const std::filesystem::path& file, std::vector<std::string>* warnings) {
  const Warnings warned;
  Message message{};
  SpecHandle spec = is_urdf(file) ? parse_urdf(file, message)
                                  : SpecHandle(mj_parseXML(file.c_str(), nullptr, message.data(),
                                                           static_cast<int>(message.size())));
  if (!spec) throw BadInput(reason_of(one_line(message.data())));
  for (const std::string& text : warned.texts()) {
    if (text.find("'NaN'") != std::string::npos) throw BadInput("a number is NaN");
    if (warnings) warnings->push_back("the simulator warns: " + one_line(text));
  }
  return spec;
}

/// @throws BadInput for a folder, or a pipe, which the simulator takes for an empty file or waits
///         for
void refuse_no_file(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error) || std::filesystem::is_regular_file(file, error)) {
    return;
  }
  throw BadInput(std::filesystem::is_directory(file, error) ? "it is a folder"
                                                            : "it is a pipe or a device");
}

}  // namespace

std::string file_link(const hand::Description& hand, std::string_view link) {
  return fmt::format("{}{}", hand.file.prefix, link);
}

std::string file_joint(const hand::Description& hand, std::string_view joint) {
  return fmt::format("{}{}", hand.file.prefix, joint);
}

std::string file_actuator(const hand::Description& hand, std::string_view actuator) {
  return fmt::format("{}{}", hand.file.actuator_prefix, actuator);
}

std::string tip_geom(const hand::Description& hand, int finger) {
  return own_name("tip_" + hand.fingers[static_cast<std::size_t>(finger)].name);
}

SpecHandle parse_model(const std::filesystem::path& file, std::vector<std::string>* warnings,
                       std::string_view kind) {
  return naming(file, kind, [&] {
    refuse_no_file(file);
    check_text(read_file(file));
    SpecHandle spec = read_xml(file, warnings);
    refuse_broken_references(*spec);
    refuse_negative_masses(*spec);
    clean(*spec);
    find_meshes(*spec, file);
    const auto massless = give_masses(*spec);
    if (warnings && !massless.empty()) {
      warnings->push_back(fmt::format("links without a mass get {} g: {}", 1000 * kLeastMass,
                                      fmt::join(massless, ", ")));
    }
    return spec;
  });
}

void place_root(mjSpec& spec, const hand::ModelFile& file) {
  mjsBody& root = find_body(spec, file.root);
  write_pose(file.T_mount_root, root.pos, root.quat);
  root.alt.type = mjORIENTATION_QUAT;
}

void put_tip(mjSpec& spec, const std::string& body, const std::string& name,
             const hand::Finger& finger) {
  const hand::TipCapsule& capsule = finger.tip;
  auto geoms = solids(find_body(spec, body));
  if (geoms.empty()) {
    throw BadInput(fmt::format("the hand's link {} has nothing to collide with", body));
  }
  mjsGeom& geom = **std::min_element(geoms.begin(), geoms.end(), [&](auto* one, auto* other) {
    return distance_to(*one, capsule.b) < distance_to(*other, capsule.b);
  });
  rename_geom(spec, geom, name);
  leave_frames(find_body(spec, body), *geom.element);
  for (mjsGeom* other : geoms) {  // all that touches at a fingertip is sensed
    if (other != &geom) other->contype = other->conaffinity = 0;
  }
  if (finger.hull) {
    become_hull(spec, geom, name, *finger.hull);
  } else {
    become_capsule(geom, capsule);
  }
  geom.alt.type = mjORIENTATION_QUAT;
  std::fill(std::begin(geom.fromto), std::end(geom.fromto),
            std::numeric_limits<double>::quiet_NaN());
}

SpecHandle parse_hand(const hand::Description& hand) {
  SpecHandle spec = parse_model(hand.file.path);
  keep_hand_only(*spec, hand.file.root);
  if (!hand.file.own_servos) remove_tendons(*spec);
  place_root(*spec, hand.file);
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    const hand::Finger& one = hand.fingers[static_cast<std::size_t>(finger)];
    const std::string& link = hand.links[static_cast<std::size_t>(one.link)].name;
    put_tip(*spec, file_link(hand, link), tip_geom(hand, finger), one);
  }
  for (const auto& [one, other] : hand.file.overlapping) {
    mjsExclude* pair = mjs_addExclude(spec.get());
    mjs_setString(pair->bodyname1, one.c_str());
    mjs_setString(pair->bodyname2, other.c_str());
  }
  return spec;
}

std::string own_name(const std::string& name) { return kOwnPrefix + name; }

void set_name(mjsElement* element, const std::string& name) {
  if (mjs_setName(element, name.c_str()) == 0) return;
  throw BadInput(
      fmt::format("the model has a {} {} already", mju_type2Str(element->elemtype), name));
}

std::vector<std::string> names_of(const mjSpec& spec, mjtObj type) {
  std::vector<std::string> names;
  for (mjsElement* e = mjs_firstElement(&spec, type); e; e = mjs_nextElement(&spec, e)) {
    if (const char* name = mjs_getString(mjs_getName(e)); *name) names.emplace_back(name);
  }
  return names;
}

mjsBody& find_body(const mjSpec& spec, const std::string& name) {
  mjsBody* body = mjs_findBody(&spec, name.c_str());
  if (!body) {
    throw BadInput(fmt::format("the hand's model has no body {}{}", name,
                               did_you_mean(name, names_of(spec, mjOBJ_BODY))));
  }
  return *body;
}

ModelHandle compile(mjSpec& spec) {
  ModelHandle model(mj_compile(&spec, nullptr));
  if (!model) {
    throw BadInput(
        fmt::format("the simulator refuses the model: {}", one_line(mjs_getError(&spec))));
  }
  return model;
}

int find_id(const mjModel& model, mjtObj type, const std::string& name) {
  const int id = mj_name2id(&model, type, name.c_str());
  if (id >= 0) return id;
  std::vector<std::string> names;
  const mjtSize count = type == mjOBJ_BODY ? model.nbody : type == mjOBJ_JOINT ? model.njnt : 0;
  for (int i = 0; i < count; ++i) {
    if (const char* one = mj_id2name(&model, type, i)) names.emplace_back(one);
  }
  throw BadInput(fmt::format("the hand's model has no {} {}{}", mju_type2Str(type), name,
                             did_you_mean(name, names)));
}

}  // namespace palpate::simulation
