// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of common/scene: the scene as structs, hashed, held against superelement files.
//
// The scene file as structs. Parsing is strict: an unknown key is an error with file, line, key,
// found, allowed.
#pragma once

#include <algorithm>
#include <array>
#include <filesystem>
#include <iosfwd>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/force_table.hpp"
#include "common/base/types.hpp"
#include "common/fem/assembly.hpp"

namespace cbr {

// Where a value stood, for messages that are found out later (a surface that the mesh does not
// have).
struct SourceLine {
  std::string file;
  int line = 0;              // from 1
  std::string text() const;  // "impact.yaml:12"
};

// Actions on a set: forces along any axis (a traction, too), a pressure, moments. A mean of the
// nodes' displacements, which a history reads, needs the answer to equal forces at them.
struct LoadKinds {
  bool forces = false, pressure = false, moments = false, means = false;
  bool acts() const { return forces || pressure || moments; }
};

// Needs of a scene of a component's interface beside the component's own options.
struct InterfaceNeeds {
  std::map<std::string, bool> touching;  // sidesets that contact names -> whether with friction
  std::optional<bool> all_touch = {};    // contact of all surfaces; with friction
  // sets that boundary conditions hold, tied surfaces, and sets that a point makes rigid
  std::vector<std::string> held = {};
  // sets of loads, of points that are no nodes, and of histories of what neither touches nor is
  // held
  std::map<std::string, LoadKinds> loaded = {};
};

// Basis characteristic: the coordinates that replace the interface's dofs.
struct CharacteristicOptions {
  // elastic characteristic constraint modes; rigid motions come on top
  Index modes = 10;
  std::vector<std::string> keep = {};  // sets whose nodes keep a coordinate for each dof
  // statics, and a uniform traction on each of their surfaces, in all directions, not only normal
  // to the faces
  bool shear = false;
  // sidesets that keep their statics; none named: those that touch
  std::vector<std::string> statics = {};
  InterfaceNeeds needs = {};  // of the scene, interface_needs(); no key of its own
  // `modes` is default_shapes(), and as many as there is room for will do
  bool is_default_modes = false;
};
// Of basis characteristic, where neither modes nor a cutoff is given.
inline constexpr Index default_modes = 80;
// A third as many as modes with the interface held, within 10 and 40:
// docs/decisions/characteristic.md.
inline Index default_shapes(const std::optional<Index>& modes) {
  return std::clamp<Index>(modes.value_or(0) / 3, 10, 40);
}

// Coordinates of the interior and of the interface: docs/formats.md, `reduction.basis`.
enum class Basis { craig_bampton, massless, characteristic };
// Which modes are kept: the lowest, or those that the interface excites most.
enum class Pick { frequency, participation };
// Basis massless: MacNeal's modes of the free body; the same with an interface part that falls off.
enum class MasslessModes { free, tapered };

// Nodes of a nodeset or sideset, and the axes along which they do not move.
struct FixedSet {
  std::string nodes;
  std::array<bool, 3> fix{};
  SourceLine source;
};

struct ReductionOptions {
  Basis basis = Basis::craig_bampton;
  std::vector<std::string> interface_sets;  // sidesets / nodesets; key `interface`
  // Rigid points of the component, each of which is a node of six dofs in the superelement; key
  // `points`.
  std::vector<std::string> interface_points;
  // In the component's axes: dofs that the superelement does not have.
  std::vector<FixedSet> fixed;
  std::optional<Index> modes;  // exactly one of modes, cutoff_hz, tolerance
  std::optional<double> cutoff_hz;
  // share of the interior's strain energy that modes may leave out (docs/theory.md)
  std::optional<double> tolerance;
  Pick pick = Pick::frequency;
  bool exact_modes = false;
  MasslessModes massless_modes = MasslessModes::free;
  Index domains = 1;  // parts that are reduced each by itself and share nodes (METIS)
  // Of the domains, put together: reduced again to the component's interface, and so to one
  // superelement. At most one of the two.
  std::optional<Index> second_modes;
  std::optional<double> second_cutoff_hz;
  // Rotations of shell nodes on the interface are dofs inside, not of the interface.
  bool condenses_rotations = false;
  // Whether every shell is hinged where its interface nodes are held.
  bool has_hinges() const { return condenses_rotations || is_massless(); }
  bool recovery = false;
  // Not empty: recovery of the elements that meet these sets or element blocks alone.
  std::vector<std::string> recovery_sets;
  // Sidesets that may lie inside the part, for loads on them; those of the scene's loads come on
  // top (load_sets()).
  std::vector<std::string> loads;
  bool is_decomposed() const { return domains > 1; }
  bool fixes(std::size_t axis) const {
    return std::any_of(fixed.begin(), fixed.end(),
                       [axis](const FixedSet& s) { return s.fix[axis]; });
  }
  bool has_second_reduction() const { return second_modes || second_cutoff_hz; }
  CharacteristicOptions characteristic;  // with that basis only
  bool is_massless() const { return basis == Basis::massless; }
  bool is_characteristic() const { return basis == Basis::characteristic; }
  std::filesystem::path superelement;  // absolute
  SourceLine source;
};

struct Component {
  std::string name;
  std::filesystem::path mesh;  // absolute
  std::string material;        // default of all blocks; may be empty when every block names one
  struct BlockOptions {
    std::string material;
    std::optional<HexFormulation> element;
    std::optional<double> thickness = {};  // of shells, which are structure then
    SourceLine source;
  };
  std::map<std::string, BlockOptions> blocks;
  // Of all blocks. Not given: as the mesh file says (Block::reduced), else `incompatible`.
  std::optional<HexFormulation> element;
  std::optional<MassKind> mass;  // not given: by use and element, component_blocks.hpp
  std::optional<ReductionOptions> reduction;
  // False: key `superelement`, a file that is used as it is. There is no mesh, material or element
  // then, and of `reduction` only the file's name; cbr-dyn takes the rest from the file.
  bool has_mesh = true;
  // In component axes. Those of the deck are among them.
  struct Point : MeshPoint {
    bool has_mass() const { return mass > 0 || !inertia.isZero(0); }
    SourceLine source;
  };
  std::map<std::string, Point> points;
  SourceLine source;
};

// Damping of a material: C = alpha M + beta K, and a loss factor that each mode gets half of as its
// damping ratio.
struct MaterialDamping {
  double alpha = 0;        // 1/s
  double beta = 0;         // s
  double loss_factor = 0;  // for motion in modes only
  bool operator==(const MaterialDamping&) const = default;
};

// Damping ratios of an instance's modes by frequency: linear in between, constant beyond. One
// entry: of all modes.
struct ModalDamping {
  std::vector<double> frequency_hz, ratio;
  bool empty() const { return ratio.empty(); }
};

enum class InstanceKind { superelement, mesh, rigid };

struct Instance {
  std::string name, component;
  InstanceKind as = InstanceKind::superelement;
  Vector3 position = Vector3::Zero();
  // Along the normal of a plane wall, or of a flat surface INSTANCE.SURFACE, the position is such
  // that the nearest node has the gap. `on` empty: not asked for, or done (place_instances()).
  struct Place {
    std::string on;
    double gap = 0;
  } place;
  Vector3 rotation_degrees = Vector3::Zero();  // about the fixed x, then y, then z axis
  // "", "x", "y" or "z": the coordinate that changes sign; before the rotation
  std::string mirror;
  Vector3 velocity = Vector3::Zero();
  ModalDamping damping;                        // added to that of its materials
  Vector3 angular_velocity = Vector3::Zero();  // rad/s, scene axes, about the centre of mass
  SourceLine source;
  Matrix3 transformation() const;  // rotation * mirror: x_scene = T x_component + position
};

struct SkinOptions {
  std::vector<std::string> surfaces;
  double youngs_modulus = 0, poissons_ratio = 0, density = 0, thickness = 0;
  std::filesystem::path mesh;  // absolute
  SourceLine source;
};

// INSTANCE.SURFACE, or the name of a rigid wall (then `instance` is empty).
struct SurfaceName {
  std::string instance, surface;
  SourceLine source;
  bool is_wall() const { return instance.empty(); }
  std::string text() const { return is_wall() ? surface : instance + "." + surface; }
};

struct History {
  std::vector<double> time, value;
  bool operator==(const History&) const = default;
};  // piecewise linear; constant before and after; empty: 1

// How the nodes of a boundary condition, or a wall, move: not at all, or by the given part of their
// motion.
enum class SupportMotion { none, displacement, velocity, acceleration };

// A rigid wall, in the scene's axes.
struct WallOptions {
  enum class Kind { plane, sphere, cylinder } kind = Kind::plane;
  std::string name;
  // of the plane or of the cylinder's axis; the sphere's centre
  Vector3 point = Vector3::Zero();
  // unit: the plane's normal, towards the bodies; the cylinder's axis
  Vector3 direction = Vector3::UnitZ();
  double radius = 0;    // of sphere and cylinder
  bool inside = false;  // bodies are inside the sphere or cylinder
  SupportMotion motion = SupportMotion::none;
  Vector3 value = Vector3::Zero();  // of the motion: the history multiplies it
  History history;
  SourceLine source;
};

// Its axes are those of the scene.
struct BoundaryCondition : FixedSet {
  std::string instance;
  // Rotations about these axes, of nodes that have any. Not given: all, where `fix` has all axes.
  std::optional<std::array<bool, 3>> fix_rotations = {};
  SupportMotion motion = SupportMotion::none;
  // of the motion: the history multiplies it; 0 along axes that are not fixed
  Vector3 value = Vector3::Zero();
  // The same of a rotation, in degrees, rad/s or rad/s^2, about a point: scene axes, or the centre
  // of the nodes.
  Vector3 turn = Vector3::Zero();
  std::optional<Vector3> about = {};
  History history;
  bool moves(Index axis) const { return motion != SupportMotion::none && value[axis] != 0; }
  bool rotates() const { return motion != SupportMotion::none && !turn.isZero(0); }
};

struct Load {
  enum class Kind { traction, force, gravity, pressure, moment } kind = Kind::traction;
  std::string instance, surface;  // empty for gravity
  bool on_point = false;          // `surface` is a point of the component: force and moment
  bool follows = false;           // turns with a body that turns (time.rotations: large)
  // scene axes; of a pressure, which pushes into the faces, the first alone
  Vector3 value = Vector3::Zero();
  History history;
  SourceLine source;
};

enum class Enforcement { impulse, penalty, nodal };

// Which points of two surfaces are kept apart.
enum class Formulation {
  automatic,  // key `auto`: node_face, or mortar for unlike faces of second order
  node_face,  // nodes of the finer surface, faces of the other
  two_way,    // nodes of each against the faces of the other (penalty only: hard constraints from
              // both sides are too many)
  mortar      // gaps integrated over the surfaces' common part
};

// Coefficients of friction, by which dynamics/contact/laws/friction_law.hpp chooses the law.
struct FrictionOptions {
  double at_rest = 0;  // 0: none
  // both or neither: the coefficient at high speed, and how fast it is reached, time per length
  std::optional<double> kinetic, decay;
};

struct ContactOptions {
  // `all`: every instance's surfaces against those of every other instance; first and second are
  // not used then.
  bool all = false;
  SurfaceName first, second;  // `second` may be a wall
  Enforcement enforcement = Enforcement::impulse;
  Formulation formulation = Formulation::automatic;
  FrictionOptions friction;
  // Key `pressures`: how many functions a face's contact has as unknowns. 0 (`nodes`): every node;
  // not given (`auto`): as many as the face needs.
  std::optional<Index> pressures;
  // penalty: pressure over depth; empty: springs as stiff as the step allows
  ForceTable stiffness;
  // penalty: share of the critical damping of the contact spring and the mass that it feels
  double damping = 0;
  // impulse, of rigid bodies: share of the normal velocity with which a point that lands leaves
  double restitution = 0;
  bool tied = false;  // joined at the start, for good
  // Joined, and pulled together along the normal by statics, then locked: by a force, or by a
  // length. At most one; tied then.
  std::optional<double> pretension_force, shortening;
  // key `overlap: resolve`: statics press surfaces apart that overlap at the start
  bool resolves_overlap = false;
  // Length by which statics press surfaces apart that touch as meshed; < 0: clearance, by which
  // they approach each other before they touch
  double interference = 0;
  // length: gaps and overlaps up to this at the start count as closed. Not given: overlaps are kept
  // as they are; ties, interference and clearances include nodes within 5 % of a face
  std::optional<double> adjust;
  SourceLine source;
};

// Two points of instances, or a point and the ground. Some of six relative motions (x, y, z, and
// rotations about them) are held or prescribed, some have springs, dashpots, tables and dry
// friction: force = -stiffness motion - damping rate - table(motion) - friction sign(rate).
struct LinkOptions {
  SurfaceName first, second;  // a wall's name in `second` is the ground
  std::array<bool, 6> fix{true, true, true, true, true, true};
  // symmetric, semi-definite; rows of motions that are free are 0
  Matrix6 stiffness = Matrix6::Zero(), damping = Matrix6::Zero();
  std::array<ForceTable, 6> force;     // over each motion
  std::array<double, 6> friction{};    // force or moment of dry friction
  Matrix3 axes = Matrix3::Identity();  // rows: x, y, z, scene axes
  // key `axes: line`: x is the line from the second end to the first, always. With the ground from
  // its place `ground`.
  bool follows_line = false;
  std::optional<Vector3> ground;
  // Of the first end relative to the second, along these axes, of motions that `fix` names: the
  // history multiplies both. Rotation in degrees, rad/s or rad/s^2.
  SupportMotion motion = SupportMotion::none;
  Vector3 value = Vector3::Zero(), turn = Vector3::Zero();
  History history;
  bool is_sprung(std::size_t m) const {
    const auto i = static_cast<Index>(m);
    return stiffness(i, i) > 0 || damping(i, i) > 0 || bends(m);
  }
  // Whether its force is no linear function of the motion.
  bool bends(std::size_t m) const { return !force[m].empty() || friction[m] > 0; }
  SourceLine source;
};

enum class Integrator { exact, central_difference, newmark };
// automatic: small until a body turns too far for it, then large from the start again
enum class Rotations { automatic, small, large };

struct TimeOptions {
  double end = 0;
  // key `static`: equilibrium in load steps, `end` and `step` are of the loads' time
  bool is_static = false;
  // load steps of statics before the time 0; not given: preload_steps()
  std::optional<Index> preload;
  std::optional<double> step;  // seconds; neither step nor cfl: auto
  // of the critical step of central differences; above 1 with newmark and exact only
  std::optional<double> cfl;
  double alpha = 0;  // newmark: HHT's, in [-1/3, 0]
  // key `force: true`: a step above the critical one is run all the same (extension)
  bool force_step = false;
  Integrator integrator = Integrator::exact;
  Rotations rotations = Rotations::automatic;
  SourceLine source;
};

// The checkpoint from which an interrupted run continues.
struct CheckpointOptions {
  // When: exactly one is given
  std::optional<double> every;  // seconds of the scene's time
  std::optional<Index> every_steps;
  std::optional<double> every_minutes;  // of the clock
  std::filesystem::path file;           // absolute; empty: beside the results
  SourceLine source;
};

// In which file fields go to viewers: XDMF over HDF5, or Exodus II.
enum class FieldFormat { xdmf, exodus };

// Stress of an instance at every output, without fields: of the nodes of a set, or of elements.
struct StressOptions {
  std::string instance;
  std::string set;              // a sideset or nodeset; empty: one of the following
  std::vector<Index> elements;  // ids of the mesh: stress at their centres
  // so many elements with the largest von Mises stress, at each output
  Index worst = 0;
  bool envelope = false;  // extremes over the outputs, of all elements and nodes
  SourceLine source;
};

// Harmonic response: `cbr-dyn --sweep`.
struct SweepOptions {
  double from_hz = 0, to_hz = 0;
  Index points = 200;
  bool is_logarithmic = false;
  std::optional<Index> modes;  // of meshes; not given: up to twice to_hz
  SourceLine source;
};

struct OutputOptions {
  double every = 0;  // 0: every step
  std::vector<SurfaceName> history;
  // displacement | velocity | stress | nodal_stress | contact_pressure | contact_slip
  std::vector<std::string> fields;
  std::vector<StressOptions> stress;
  std::vector<SurfaceName> reactions;  // sets that `boundary` holds
  FieldFormat format = FieldFormat::xdmf;
  std::optional<CheckpointOptions> checkpoint;
  SourceLine source;
};

struct Scene {
  std::filesystem::path file;  // "-" when read from stdin
  std::map<std::string, Material> materials;
  std::map<std::string, MaterialDamping> damping;  // of those materials that have any
  std::map<std::string, Component> components;
  std::vector<Instance> instances;  // in the file's order
  std::optional<SkinOptions> skin;
  std::vector<BoundaryCondition> boundary;
  std::vector<Load> loads;
  std::vector<WallOptions> walls;  // in the file's order
  std::vector<ContactOptions> contact;
  std::vector<LinkOptions> links;
  std::optional<TimeOptions> time;
  std::optional<SweepOptions> sweep;
  OutputOptions output;
};

// Reads a scene; "-" is stdin. Relative paths are resolved against the scene file's folder (stdin:
// the working directory). InputError for everything that can be known without opening another file.
Scene read_scene(const std::string& file_or_dash);

// Load steps of statics before the time 0: as given, else some where the scene has a pretension or
// an overlap to resolve, else none.
Index preload_steps(const Scene& scene);

// The scene as YAML with absolute paths, for the next program of a pipeline.
// read_scene(write_scene(s)) == s.
void write_scene(const Scene& scene, std::ostream& out);

const Component& component_of(const Scene& scene, const Instance& instance);
// A reference point of the instance's component; nullptr: there is none of this name.
const Component::Point* point_of(const Scene& scene, const std::string& instance,
                                 const std::string& name);
// Gives blocks their thickness. InputError: one that is not of tri3 or quad4.
void mark_shells(const Component& component, Mesh& mesh);

// The component's mesh, whose blocks with a thickness are shells. Their faces are sidesets, BLOCK
// along their normals and BLOCK.back turned over, and their edges nodesets. InputError: as
// read_mesh() of the file, and as above.
Mesh read_mesh(const Component& component);

// Key `element` of the block, else of the component.
std::optional<HexFormulation> element_of(const Component& component,
                                         const Component::BlockOptions* block);
// Orthotropy::axes from axis 1 and a vector of the plane 1-2, of any length; none if they are zero
// or parallel.
std::optional<Matrix3> material_axes(const Vector3& axis, const Vector3& in_plane);

// One per mesh block. InputError: a block named in the scene that the mesh does not have; a block
// without a material.
std::vector<BlockProperties> block_properties(const Scene& scene, const Component& component,
                                              const Mesh& mesh);

// Names, ascending, of the sets that loads act on: those of reduction.loads, and those of the
// scene's loads on instances of the component that stand as superelements. Some of them may be on
// the interface.
std::vector<std::string> load_sets(const Scene& scene, const Component& component);

// InputError "WHERE: ..." for options that basis massless cannot be had with.
void check_massless(const ReductionOptions& reduction, const std::string& where);
// the same of basis characteristic
void check_characteristic(const ReductionOptions& reduction, const std::string& where);

// XXH3 (128 bit, hex) of a file's bytes. InputError when it cannot be read. Of a mesh, with those
// of the files that it includes.
std::string file_hash(const std::filesystem::path& file);
std::string mesh_hash(const std::filesystem::path& file);
std::string bytes_hash(std::string_view bytes);  // the same of bytes in memory

// Needs of contact and boundary conditions of the component, over all instances that stand as its
// superelement. Of a mesh without a scene (Scene::file is empty): all sets of its interface may
// touch, without friction.
InterfaceNeeds interface_needs(const Scene& scene, const Component& component);

// Whether a run may read the diagonal form of the component's superelement: not where boundary
// conditions hold every instance, as the form is that of the free component. True without a run (no
// `time`), whose scene is still to come.
bool reads_diagonal_form(const Scene& scene, const Component& component);

// Hash (hex) of all that a component's superelement depends on: the mesh file's bytes, materials,
// elements, mass, reduction options; no paths, no times. InputError when the mesh cannot be read.
std::string content_hash(const Scene& scene, const Component& component);

}  // namespace cbr
