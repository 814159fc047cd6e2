// SPDX-License-Identifier: GPL-3.0-or-later
// Bulk data of Nastran: cards of small fields (8 columns), large ones (16), or between commas, over
// as many lines as they take; and a mesh from them. Properties of solids become blocks,
// those of faces on them sidesets; sets of points nodesets. MSC Nastran Quick Reference Guide,
// "Format of Bulk Data Entries".
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "common/base/error.hpp"
#include "common/mesh/io/deck_lines.hpp"
#include "common/mesh/io/file_mesh.hpp"
#include "common/mesh/io/mesh_formats.hpp"

namespace cbr {
namespace {

struct BdfCard {
  std::string name;  // in capitals, without an asterisk
  // those after the name, trimmed; continuations follow one another
  std::vector<std::string> fields;
  DeckPlace place;
};

class BdfCards {
 public:
  explicit BdfCards(const std::filesystem::path& file);

  bool is_of_gmsh() const { return is_of_gmsh_; }
  // The next card of the bulk data; none after ENDDATA or the last line.
  std::optional<BdfCard> next();
  // InputError "FILE:LINE: what", with the card's line.
  [[noreturn]] void fail(const BdfCard& card, const std::string& what) const {
    card.place.fail(card.name + ": " + what);
  }

  // Field i, from 0. Empty: none, or blank.
  std::string text(const BdfCard& card, std::size_t i) const;
  // InputError unless a whole number
  Index whole(const BdfCard& card, std::size_t i) const;
  // "1.5", "1.5E3", "1.5D3" and "1.5+3"
  double real(const BdfCard& card, std::size_t i, double blank) const;

 private:
  bool next_line();
  bool is_continuation() const;
  void add_fields(BdfCard& card) const;

  DeckLines lines_;
  std::string line_;  // without comment, tabs expanded
  bool has_line_ = false, is_bulk_ = false;
  bool must_end_ = false, is_of_gmsh_ = false;  // with ENDDATA; of gmsh
};

constexpr std::size_t small = 8, large = 16, last_column = 72;

std::string_view columns(const std::string& line, std::size_t first, std::size_t width) {
  return first < line.size() ? trimmed(std::string_view(line).substr(first, width))
                             : std::string_view();
}

// Without the comment, with tabs as blanks up to the next field.
std::string plain(const std::string& line) {
  std::string out;
  for (const char c : line) {
    if (c == '$') break;
    out += c == '\t' ? ' ' : c;
    while (c == '\t' && out.size() % small != 0) out += ' ';
  }
  return out;
}

std::string name_of(const std::string& line) {
  const auto comma = line.find(',');
  return in_capitals(trimmed(comma == std::string::npos ? columns(line, 0, small)
                                                        : std::string_view(line).substr(0, comma)));
}

BdfCards::BdfCards(const std::filesystem::path& file) : lines_(file, DeckLines::Kind::bdf) {
  // A file may begin with the executive and case control sections
  DeckLines all(file, DeckLines::Kind::bdf);
  is_bulk_ = true;
  // A whole deck ends with ENDDATA, and so does what gmsh writes; bulk data alone need not
  while (all.next()) {
    if (all.line().find('\0') != std::string::npos)
      all.fail("is no text: expected bulk data of Nastran");
    const std::string start = in_capitals(trimmed(plain(all.line()).substr(0, 40)));
    if (start.starts_with("BEGIN") && start.find("BULK") != std::string::npos) is_bulk_ = false;
    is_of_gmsh_ |= all.line().starts_with("$ Created by Gmsh");
  }
  must_end_ = !is_bulk_ || is_of_gmsh_;
}

bool BdfCards::next_line() {
  while (!has_line_) {
    if (!lines_.next()) return false;
    line_ = plain(lines_.line());
    const std::string_view text = trimmed(line_);
    if (text.empty()) continue;
    if (!is_bulk_) {
      is_bulk_ = in_capitals(text.substr(0, 5)) == "BEGIN";
      continue;
    }
    has_line_ = true;
  }
  return true;
}

bool BdfCards::is_continuation() const {
  const std::string name = name_of(line_);
  return name.empty() || name[0] == '+' || name[0] == '*';
}

void BdfCards::add_fields(BdfCard& card) const {
  if (line_.find(',') != std::string::npos) {
    const auto fields = fields_of(line_, ',');
    // the tenth marks the continuation
    const std::size_t wanted = std::min<std::size_t>(fields.size(), 9);
    for (std::size_t i = 1; i < wanted; ++i) card.fields.emplace_back(fields[i]);
    if (wanted < 9) card.fields.resize(card.fields.size() + 9 - wanted);
    return;
  }
  const bool is_large = columns(line_, 0, small).find('*') != std::string_view::npos;
  const std::size_t width = is_large ? large : small;
  for (std::size_t first = small; first < last_column; first += width)
    card.fields.emplace_back(columns(line_, first, width));
}

std::optional<BdfCard> BdfCards::next() {
  if (!next_line()) {
    if (must_end_) lines_.fail("ends without ENDDATA: the file is cut short, export it again");
    return std::nullopt;
  }
  BdfCard card{name_of(line_), {}, lines_.place()};
  if (card.name == "ENDDATA") return std::nullopt;
  if (is_continuation()) fail(card, "a continuation without the card before it");
  if (card.name.ends_with('*')) card.name.pop_back();
  card.name = std::string(trimmed(card.name));
  do {
    add_fields(card);
    has_line_ = false;
  } while (next_line() && is_continuation());
  return card;
}

std::string BdfCards::text(const BdfCard& card, std::size_t i) const {
  return i < card.fields.size() ? card.fields[i] : "";
}

Index BdfCards::whole(const BdfCard& card, std::size_t i) const {
  const std::string field = text(card, i);
  if (field.empty() ||
      field.find_first_not_of("0123456789", field[0] == '+' ? 1 : 0) != std::string::npos ||
      field.size() > 15)
    fail(card,
         "'" + field + "' found in field " + std::to_string(i + 2) + ", expected a whole number");
  return std::stoll(field);
}

double BdfCards::real(const BdfCard& card, std::size_t i, double blank) const {
  std::string field = text(card, i);
  if (field.empty()) return blank;
  // An exponent may stand without a letter
  const auto sign = field.find_last_of("+-");
  if (sign != std::string::npos && sign > 0 &&
      std::string_view("0123456789.").find(field[sign - 1]) != std::string_view::npos)
    field.insert(sign, "E");
  const auto exponent = field.find_first_of("eEdD");
  if (exponent != std::string::npos && exponent + 1 < field.size() && field[exponent + 1] == '+')
    field.erase(exponent + 1, 1);
  try {
    return lines_.number(field);
  } catch (const InputError&) {  // which has the line after the card
    fail(card, "'" + text(card, i) + "' found, expected a finite number");
  }
}

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
