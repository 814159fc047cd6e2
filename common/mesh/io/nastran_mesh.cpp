// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh from bulk data of Nastran. Properties of solids become blocks, those of faces on them
// sidesets; sets of points nodesets.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <unordered_set>

#include "common/base/error.hpp"
#include "common/mesh/io/bdf_cards.hpp"
#include "common/mesh/io/deck_lines.hpp"
#include "common/mesh/io/file_mesh.hpp"
#include "common/mesh/io/mesh_formats.hpp"

namespace cbr {
namespace {

// Types by the number of points; they follow in the order of Exodus II.
struct Family {
  const char* card;
  std::vector<ElementType> types;
};

const Family* family_of(const std::string& card) {
  using enum ElementType;
  static const std::vector<Family> families = {
      {"CTETRA", {tet4, tet10}}, {"CPYRAM", {pyramid5}}, {"CPENTA", {wedge6, wedge15}},
      {"CHEXA", {hex8, hex20}},  {"CTRIA3", {tri3}},     {"CTRIAR", {tri3}},
      {"CTRIA6", {tri6}},        {"CQUAD4", {quad4}},    {"CQUADR", {quad4}},
      {"CQUAD8", {quad8}}};
  for (const Family& family : families)
    if (card == family.card) return &family;
  return nullptr;
}

class NastranMesh {
 public:
  explicit NastranMesh(const std::filesystem::path& file) : cards_(file) {
    file_.where = file.string();
  }

  Mesh run() {
    while (const auto card = cards_.next()) take(*card);
    if (file_.node_ids.empty())
      throw InputError(file_.where + ": holds no GRID: not bulk data of Nastran, or damaged");
    for (const auto& [property, material] : material_of_) add_material(property, material);
    std::vector<FaceSet> faces;
    for (const auto& [property, elements] : faces_)
      faces.push_back({face_name(property), elements});
    Mesh mesh = mesh_of(file_, faces);
    mesh.dropped = dropped_.text(file_.where);
    const MeshIds ids(mesh);
    for (const auto& [name, points] : points_) {
      std::vector<Index> nodes;
      for (const Index id : points)  // a range may name points that there are not
        if (const Index node = ids.node(id); node >= 0) nodes.push_back(node);
      if (!nodes.empty()) add_nodeset(mesh, name, nodes);
    }
    add_joined_points(mesh);
    return mesh;
  }

 private:
  static std::string solid_name(Index property) { return "volume_" + std::to_string(property); }
  static std::string face_name(Index property) { return "surface_" + std::to_string(property); }

  void take(const BdfCard& card) {
    if (card.name == "GRID") take_point(card);
    if (card.name == "PSOLID") material_of_[cards_.whole(card, 0)] = cards_.whole(card, 1);
    if (card.name == "MAT1") take_material(card);
    const bool is_other_law = is_among("MAT2 MAT3 MAT8 MAT9 MAT10 MAT11 MAT12 MATHP", card.name);
    if (is_other_law)
      materials_[cards_.whole(card, 0)] = {.name = cards_.text(card, 0),
                                           .problem = "is a " + card.name + ", not supported"};
    if (card.name == "PARAM" && cards_.text(card, 0) == "WTMASS")
      weight_to_mass_ = cards_.real(card, 1, 1);
    if (card.name == "RBE2") take_rigid(card);
    if (card.name == "RBE3") take_average(card);
    if (card.name == "CONM2") masses_.push_back(card);
    if (card.name == "SET1") take_points(card, "set_" + cards_.text(card, 0), 1);
    if (card.name == "SPC1") take_points(card, "spc_" + cards_.text(card, 0), 2);
    if (card.name == "ASET1") take_points(card, "aset", 1);
    if (const Family* family = family_of(card.name)) return take_element(card, *family);
    refuse(card);
    if (!is_other_law) drop(card);
  }

  // Cards that are not read, but for those without effect on the part, and curves of gmsh.
  void drop(const BdfCard& card) {
    const bool is_parameter = card.name == "PARAM";
    if (is_among(
            "GRID PSOLID PSHELL MAT1 RBE2 RBE3 CONM2 SET1 SPC1 ASET1 CORD1R CORD2R CORD1C CORD2C "
            "CORD1S CORD2S EIGRL EIGR TSTEP FREQ FREQ1",
            card.name) ||
        (card.name == "CBAR" && cards_.is_of_gmsh()) ||
        (is_parameter && !is_among("ALPHA1 ALPHA2 G", cards_.text(card, 0))))
      return;
    dropped_.add(is_parameter ? "PARAM," + cards_.text(card, 0) : card.name, card.place);
  }

  // These change the part: each is an error with its cure. Bars without a property are the
  // curves of a mesh.
  void refuse(const BdfCard& card) const {
    static const std::vector<Instead> all = {
        {instead_of_points, {"RBE1", "RBAR", "RROD", "CONM1"}},
        {instead_of_equations, {"MPC", "MPCADD"}},
        {instead_of_springs,
         {"CELAS1", "CELAS2", "CELAS3", "CELAS4", "CBUSH", "CDAMP1", "CDAMP2", "CVISC"}},
        {instead_of_gaps, {"CGAP"}},
        {instead_of_ties, {"CWELD", "CFAST"}},
        {"not in this version: take rods and beams out of the mesh",
         {"CROD", "CONROD", "PBAR", "PBARL", "PBEAM", "PBEAML"}}};
    if (const std::string cure = cure_of(all, card.name); !cure.empty())
      cards_.fail(card, "found: " + cure);
  }

  void take_point(const BdfCard& card) {
    const std::string system = cards_.text(card, 1);
    if (!system.empty() && system != "0")
      cards_.fail(card, "coordinate system " + system + " found, expected 0 (basic)");
    file_.node_ids.push_back(cards_.whole(card, 0));
    for (std::size_t c = 2; c < 5; ++c) file_.coordinates.push_back(cards_.real(card, c, 0));
  }

  void take_element(const BdfCard& card, const Family& family) {
    const Index id = cards_.whole(card, 0),
                property = cards_.text(card, 1).empty() ? id : cards_.whole(card, 1);
    std::vector<Index> nodes;
    const auto most = static_cast<std::size_t>(n_nodes(family.types.back()));
    for (std::size_t i = 2; i < 2 + most && !cards_.text(card, i).empty(); ++i)
      nodes.push_back(cards_.whole(card, i));
    const auto type = std::find_if(family.types.begin(), family.types.end(), [&](ElementType one) {
      return static_cast<std::size_t>(n_nodes(one)) == nodes.size();
    });
    if (type == family.types.end() || (dimension(*type) == 3 && has_more(card, 2 + nodes.size())))
      cards_.fail(card, "element " + std::to_string(id) + " has " + std::to_string(nodes.size()) +
                            " points, expected " + counts_text(family));
    const bool is_face = dimension(*type) == 2;
    if (is_face) faces_[property].push_back(file_.elements.size());
    file_.elements.push_back({id, *type, file_.element_nodes.size(),
                              is_face ? face_name(property) : solid_name(property)});
    file_.element_nodes.insert(file_.element_nodes.end(), nodes.begin(), nodes.end());
  }

  // Points of some mid-edges. Faces have angles and thicknesses there.
  static bool has_more(const BdfCard& card, std::size_t first) {
    for (std::size_t i = first; i < card.fields.size(); ++i)
      if (!card.fields[i].empty()) return true;
    return false;
  }

  static std::string counts_text(const Family& family) {
    std::vector<std::string> counts;
    for (const ElementType type : family.types) counts.push_back(std::to_string(n_nodes(type)));
    return join(counts);
  }

  // Points, or FIRST THRU LAST, from this field on.
  void take_points(const BdfCard& card, const std::string& name, std::size_t first) {
    std::vector<Index>& points = points_[name];
    for (std::size_t i = first; i < card.fields.size(); ++i) {
      if (card.fields[i].empty()) continue;
      if (card.fields[i] != "THRU") {
        points.push_back(cards_.whole(card, i));
        continue;
      }
      const Index last = cards_.whole(card, ++i);
      if (points.empty() || last < points.back() || last - points.back() > most_in_range)
        cards_.fail(card, "THRU expects a number before it and a larger one after it");
      for (Index id = points.back() + 1; id <= last; ++id) points.push_back(id);
    }
  }

  // EID GN CM GM1 GM2 ... ALPHA: the nodes GM move as a rigid body with GN.
  void take_rigid(const BdfCard& card) {
    const std::string motions = cards_.text(card, 2), name = "rbe2_" + cards_.text(card, 0);
    for (const char motion : {'1', '2', '3'})
      if (motions.find(motion) == std::string::npos)
        cards_.fail(card,
                    name.substr(5) + " has CM = " + motions +
                        ", expected 123456, or 123 of solids: others are not in this version; "
                        "use RBE3, and a link of the scene from its point (links[].fix)");
    BdfCard nodes = card;
    if (cards_.text(card, last_field(card)).find('.') != std::string::npos)
      nodes.fields.resize(last_field(card));
    take_points(nodes, name, 3);
    joined_.add(cards_.whole(card, 1), {name, Vector3::Zero(), true, card.place});
  }

  // EID - REFGRID REFC WT1 C1 G11 G12 ... WT2 C2 G21 ...: the node has the mean motion of the
  // others.
  void take_average(const BdfCard& card) {
    const std::string id = cards_.text(card, 0), name = "rbe3_" + id;
    const auto expect = [&](const std::string& what, const std::string& found,
                            const std::string& only) {
      if (found != only)
        cards_.fail(card, id + " has " + what + " = " + found + ", expected " + only +
                              ": take the mean of all motions, with equal weights");
    };
    expect("REFC", cards_.text(card, 3), "123456");
    std::vector<Index>& nodes = points_[name];
    for (std::size_t i = 4; i < card.fields.size(); ++i) {
      const std::string& field = card.fields[i];
      if (field == "ALPHA") break;
      if (field == "UM") cards_.fail(card, id + " has UM, which is not read: take it out");
      if (field.find('.') != std::string::npos) {
        expect("a weight", field, cards_.text(card, 4));
        expect("components", cards_.text(card, ++i), "123");
      } else if (!field.empty()) {
        nodes.push_back(cards_.whole(card, i));
      }
    }
    joined_.add(cards_.whole(card, 2), {name, Vector3::Zero(), false, card.place});
  }

  static std::size_t last_field(const BdfCard& card) {
    std::size_t last = card.fields.size();
    while (last > 0 && card.fields[last - 1].empty()) --last;
    return last == 0 ? 0 : last - 1;
  }

  // Nodes of sets must be those of elements; a rigid set holds the node that it moves with if that
  // is one.
  void add_joined_points(Mesh& mesh) {
    const MeshIds ids(mesh);
    const std::unordered_set<Index> used =
        joined_.points.empty() ? std::unordered_set<Index>() : used_nodes(file_);
    const auto refuse = [&](const FilePoints::Point& of, Index id, const std::string& what) {
      of.place.fail("node " + std::to_string(id) + " of '" + of.nodes + "' " + what);
    };
    for (auto& [node, point] : joined_.points) {
      for (const Index id : points_.at(point.nodes))
        if (!used.contains(id))
          refuse(point, id,
                 "is a node of no element: not in this version; use nodes of the mesh, and links "
                 "of the scene between points (links)");
      if (ids.node(node) < 0) refuse(point, node, "is no GRID");
      if (used.contains(node) && !point.rigid)
        refuse(point, node, "is a node of an element: give it a GRID of its own");
      if (used.contains(node)) add_nodeset(mesh, point.nodes, {ids.node(node)});
      point.at = mesh.coordinates.row(ids.node(node));
    }
    for (const BdfCard& card : masses_) add_mass(card, mesh, ids);
    add_points(joined_, mesh);
  }

  // EID G CID M X1 X2 X3 - I11 I21 I22 I31 I32 I33; I21 is int rho x y dV.
  void add_mass(const BdfCard& card, const Mesh& mesh, const MeshIds& ids) {
    const std::string id = cards_.text(card, 0), system = cards_.text(card, 2);
    if (!system.empty() && system != "0" && system != "-1")
      cards_.fail(card, id + " has coordinate system " + system + ", expected 0 (basic) or -1");
    std::array<double, 14> x{};
    for (std::size_t i = 3; i < x.size(); ++i) x[i] = cards_.real(card, i, 0);
    FilePoints::Mass mass{"mass_" + id, cards_.whole(card, 1), x[3], {}, {}, card.place};
    mass.inertia << x[8], -x[9], -x[11], -x[9], x[10], -x[12], -x[11], -x[12], x[13];
    mass.offset = Vector3(x[4], x[5], x[6]);
    if (system == "-1" && ids.node(mass.node) >= 0)
      mass.offset -= mesh.coordinates.row(ids.node(mass.node)).transpose();
    mass.mass *= weight_to_mass_;
    mass.inertia *= weight_to_mass_;
    joined_.masses.push_back(mass);
  }

  void take_material(const BdfCard& card) {
    FileMaterial material{.name = "MAT1 " + cards_.text(card, 0)};
    const double none = std::nan("");
    double E = cards_.real(card, 1, none), G = cards_.real(card, 2, none),
           nu = cards_.real(card, 3, none);
    if (std::isnan(nu)) nu = std::isnan(G) ? 0 : E / (2 * G) - 1;
    if (std::isnan(E)) E = 2 * (1 + nu) * G;
    if (std::isnan(E)) material.problem = "has neither E nor G";
    // All three may be given; G is then another material than an isotropic one
    if (!std::isnan(G) && std::abs(E - 2 * (1 + nu) * G) > 0.01 * std::abs(E))
      material.problem = "has E, G and NU that do not fit";
    material.youngs_modulus = E;
    material.poissons_ratio = nu;
    material.density = cards_.real(card, 4, 0);
    if (cards_.real(card, 7, 0) != 0) dropped_.add("GE of MAT1", card.place);
    materials_[cards_.whole(card, 0)] = material;
  }

  void add_material(Index property, Index id) {
    const auto found = materials_.find(id);
    FileMaterial material =
        found != materials_.end()
            ? found->second
            : FileMaterial{.name = std::to_string(id), .problem = "is not in the file"};
    material.density *= weight_to_mass_;
    file_.materials[solid_name(property)] = material;
  }

  static constexpr Index most_in_range = 100'000'000;

  BdfCards cards_;
  FileMesh file_;
  std::map<Index, std::vector<std::size_t>> faces_;  // by property
  std::map<Index, Index> material_of_;               // by property
  std::map<Index, FileMaterial> materials_;
  std::map<std::string, std::vector<Index>> points_;
  FilePoints joined_;
  std::vector<BdfCard> masses_;
  double weight_to_mass_ = 1;
  DroppedWords dropped_;
};

}  // namespace

Mesh read_nastran_mesh(const std::filesystem::path& file) { return NastranMesh(file).run(); }

}  // namespace cbr
