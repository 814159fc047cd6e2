// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh from bulk data of Nastran. Properties of solids become blocks, those of faces on them
// sidesets; sets of points nodesets.
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

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
    return mesh;
  }

 private:
  static std::string solid_name(Index property) { return "volume_" + std::to_string(property); }
  static std::string face_name(Index property) { return "surface_" + std::to_string(property); }

  void take(const BdfCard& card) {
    if (card.name == "GRID") take_point(card);
    if (card.name == "PSOLID") material_of_[cards_.whole(card, 0)] = cards_.whole(card, 1);
    if (card.name == "MAT1") take_material(card);
    static const std::set<std::string> laws = {"MAT2",  "MAT3",  "MAT8",  "MAT9",
                                               "MAT10", "MAT11", "MAT12", "MATHP"};
    if (laws.contains(card.name))
      materials_[cards_.whole(card, 0)] = {.name = cards_.text(card, 0),
                                           .problem = "is a " + card.name + ", not supported"};
    if (card.name == "PARAM" && cards_.text(card, 0) == "WTMASS")
      weight_to_mass_ = cards_.real(card, 1, 1);
    if (card.name == "SET1") take_points(card, "set_" + cards_.text(card, 0), 1);
    if (card.name == "SPC1") take_points(card, "spc_" + cards_.text(card, 0), 2);
    if (card.name == "ASET1") take_points(card, "aset", 1);
    if (const Family* family = family_of(card.name)) return take_element(card, *family);
    refuse(card);
    if (!laws.contains(card.name)) drop(card);
  }

  // Cards that are not read, but for those without effect on the part, and curves of gmsh.
  void drop(const BdfCard& card) {
    static const std::set<std::string> silent = {
        "GRID",   "PSOLID", "PSHELL", "MAT1",   "SET1",  "SPC1", "ASET1", "CORD1R", "CORD2R",
        "CORD1C", "CORD2C", "CORD1S", "CORD2S", "EIGRL", "EIGR", "TSTEP", "FREQ",   "FREQ1"};
    static const std::set<std::string> damping = {"ALPHA1", "ALPHA2", "G"};
    const bool is_parameter = card.name == "PARAM";
    if (silent.contains(card.name) || (card.name == "CBAR" && cards_.is_of_gmsh()) ||
        (is_parameter && !damping.contains(cards_.text(card, 0))))
      return;
    dropped_.add(is_parameter ? "PARAM," + cards_.text(card, 0) : card.name, card.place);
  }

  // These change the part: each is an error with its cure. Bars without a property are the
  // curves of a mesh.
  void refuse(const BdfCard& card) const {
    static const std::vector<Instead> all = {
        {instead_of_points, {"RBE1", "RBE2", "RBE3", "RBAR", "RROD", "CONM1", "CONM2"}},
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
  double weight_to_mass_ = 1;
  DroppedWords dropped_;
};

}  // namespace

Mesh read_nastran_mesh(const std::filesystem::path& file) { return NastranMesh(file).run(); }

}  // namespace cbr
