// SPDX-License-Identifier: GPL-3.0-or-later
// Keywords: Abaqus Keywords Reference Guide; Dhondt, CalculiX CrunchiX User's Manual, "Input deck
// format".
#include "common/mesh/io/inp_file.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
#include <utility>

#include "common/base/error.hpp"

namespace cbr {
namespace {

struct InpType {
  std::optional<ElementType> type;  // none: of one dimension
  int n_nodes = 0;
  bool reduced = false;  // Block::reduced
  bool is_plane = false;
};

// The number after a prefix is that of the nodes; of letters after it (R, I, H, M, T) only R
// counts, reduced integration of hexes. C3D15 has the nine points of wedge15's reduced integration.
std::optional<InpType> inp_type(const std::string& word) {
  using enum ElementType;
  struct Family {
    const char* prefix;
    std::vector<ElementType> types;
  };
  static const std::vector<ElementType> faces = {tri3, quad4, tri6, quad8, quad9};
  static const std::vector<Family> families = {
      {"C3D", {tet4, pyramid5, wedge6, hex8, tet10, wedge15, hex20}},
      {"CPS", faces},
      {"CPE", faces},
      {"STRI", faces},
      {"SFM3D", faces},
      {"M3D", faces},
      {"R3D", faces},
      {"S", faces}};
  static const std::map<std::string, int> lines = {
      {"T3D2", 2}, {"T3D3", 3}, {"T2D2", 2},    {"T2D3", 3},   {"B31", 2},
      {"B31R", 2}, {"B32", 3},  {"B32R", 3},    {"B33", 2},    {"B21", 2},
      {"B22", 3},  {"MASS", 1}, {"ROTARYI", 1}, {"DCOUP3D", 1}};
  if (const auto line = lines.find(word); line != lines.end())
    return InpType{std::nullopt, line->second};
  for (const Family& family : families) {
    const std::string prefix = family.prefix;
    if (!word.starts_with(prefix)) continue;
    const std::string rest = word.substr(prefix.size());
    std::string digits = rest.substr(0, rest.find_first_not_of("0123456789"));
    const bool reduced = digits == "15" ||
                         ((digits == "8" || digits == "20") && rest.find('R') != std::string::npos);
    if (prefix == "STRI" && digits == "65") digits = "6";
    for (const ElementType type : family.types)
      if (digits == std::to_string(n_nodes(type)))
        return InpType{type, n_nodes(type), reduced && dimension(type) == 3, prefix[1] == 'P'};
  }
  return std::nullopt;
}

class InpReader {
 public:
  explicit InpReader(const std::filesystem::path& file) : lines_(file, DeckLines::Kind::inp) {
    file_.mesh.where = file.string();
  }

  InpFile run() {
    while (lines_.next()) {
      const std::string_view line = trimmed(lines_.line());
      if (line.empty() || line.starts_with("**")) continue;
      if (line.find('\0') != std::string_view::npos)
        lines_.fail("is no text: expected an input file of Abaqus or CalculiX");
      if (line.front() != '*') {
        if (take_) take_(fields_of(line, ','));
        waits_for_data_.clear();
        continue;
      }
      require_whole_element();
      if (lines_.keyword().is("STEP")) {
        waits_for_data_.clear();
        drop(lines_.keyword());
        require_end_of_steps();
        break;
      }
      begin(lines_.keyword());
    }
    require_whole_element();
    require_whole_file();
    file_.dropped = dropped_.text(file_.mesh.where, "*STEP");
    if (file_.mesh.node_ids.empty())
      lines_.fail("holds no *NODE: not a mesh of Abaqus or CalculiX, or a damaged one");
    return std::move(file_);
  }

 private:
  using Fields = std::vector<std::string_view>;
  using Take = std::function<void(const Fields&)>;  // of a line of data

  void begin(const InpKeyword& keyword) {
    refuse(keyword);
    take_ = nullptr;
    const std::string& name = keyword.name;
    if (name == "PART" || name == "ASSEMBLY" || name == "INSTANCE") open_.push_back(name);
    if (!open_.empty() && name == "END" + open_.back()) open_.pop_back();
    waits_for_data_.clear();
    if (is_among("NODE ELEMENT NSET ELSET SURFACE ELASTIC DENSITY ORIENTATION MASS ROTARYINERTIA "
                 "DISTRIBUTINGCOUPLING",
                 name))
      waits_for_data_ = name;
    if (name == "ASSEMBLY" || name == "ENDASSEMBLY") in_assembly_ = name == "ASSEMBLY";
    if (name == "PART" && ++n_parts_ > 1)
      lines_.fail("a second *PART: a component is one part, give each a file of its own");
    if (name == "INSTANCE") {
      if (++n_instances_ > 1)
        lines_.fail(
            "a second *INSTANCE: a component is one part; instances are those of the scene");
      take_ = [this](const Fields& fields) { require_no_placement(fields); };
    }
    if (name == "NODE") begin_nodes(keyword);
    if (name == "ELEMENT") begin_elements(keyword);
    if (name == "NSET") begin_set(keyword, "NSET", file_.nsets, file_.nset_order);
    if (name == "ELSET") begin_set(keyword, "ELSET", file_.elsets, file_.elset_order);
    if (name == "SURFACE") begin_surface(keyword);
    if (is_section(keyword)) {
      file_.sections.push_back({in_capitals(keyword.value("ELSET")),
                                in_capitals(keyword.value("MATERIAL")),
                                in_capitals(keyword.value("ORIENTATION")), lines_.place()});
    }
    if (name == "MATERIAL") {
      material_ = &file_.materials[in_capitals(keyword.value("NAME"))];
      *material_ = {.name = keyword.value("NAME")};
      has_elastic_ = has_density_ = false;
    }
    if (name == "ORIENTATION") begin_orientation(keyword);
    if (name == "ELASTIC" && material_ != nullptr) begin_elastic(keyword);
    if (name == "DENSITY" && material_ != nullptr)
      take_ = [this](const Fields& fields) {
        take_constants(fields, has_density_, {&material_->density, nullptr});
      };
    if (name == "DAMPING" && material_ != nullptr) begin_damping(keyword);
    if (name == "COUPLING" || name == "RIGIDBODY") begin_constraint(keyword);
    if (name == "KINEMATIC" || name == "DISTRIBUTING") begin_motions(keyword);
    if (name == "DISTRIBUTINGCOUPLING") begin_distribution(keyword);
    if (name == "MASS" || name == "ROTARYINERTIA") begin_mass(keyword);
    if (!is_read(keyword)) drop(keyword);
  }

  static bool is_section(const InpKeyword& keyword) {
    return is_among("SOLIDSECTION SHELLSECTION BEAMSECTION MEMBRANESECTION", keyword.name);
  }

  // Read, or without effect: titles, output requests, and ends.
  bool is_read(const InpKeyword& keyword) const {
    if (is_among("NODE ELEMENT NSET ELSET SURFACE MATERIAL ELASTIC DENSITY PART ASSEMBLY INSTANCE "
                 "ORIENTATION COUPLING KINEMATIC DISTRIBUTING DISTRIBUTINGCOUPLING RIGIDBODY MASS "
                 "ROTARYINERTIA HEADING PREPRINT RESTART NODEPRINT NODEFILE ELPRINT ELFILE "
                 "ELEMENTOUTPUT NODEOUTPUT "
                 "OUTPUT CONTACTPRINT CONTACTFILE FILEFORMAT PHYSICALCONSTANTS",
                 keyword.name))
      return true;
    if (keyword.is("DAMPING")) return material_ != nullptr && !keyword.has("COMPOSITE");
    return is_section(keyword) || keyword.name.starts_with("END");
  }

  void drop(const InpKeyword& keyword) {
    dropped_.add("*" + in_capitals(keyword.shown), lines_.place());
  }

  void begin_damping(const InpKeyword& keyword) {
    const auto take = [&](const char* parameter, double& value) {
      if (!keyword.has(parameter)) return;
      value = lines_.number(keyword.value(parameter));
      if (value < 0) lines_.fail("*DAMPING: " + std::string(parameter) + " is below 0");
    };
    take("ALPHA", material_->alpha);
    take("BETA", material_->beta);
    take("STRUCTURAL", material_->loss_factor);
  }

  // These change the part: each is an error with its cure.
  void refuse(const InpKeyword& keyword) const {
    static const std::vector<Instead> all = {
        {instead_of_ties, {"TIE"}},
        {instead_of_equations, {"EQUATION", "MPC"}},
        {instead_of_points, {"KINEMATICCOUPLING"}},
        {"not in this version: mesh the parts so that they share nodes", {"EMBEDDEDELEMENT"}},
        {"cyclic symmetry is not in this version: mesh the whole part", {"CYCLICSYMMETRYMODEL"}},
        {"not in this version: take it out; superelements of matrices are read by cbr-reduce "
         "--import",
         {"MATRIXINPUT", "MATRIXASSEMBLE", "USERELEMENT"}},
        {"not in this version: write the part as it is without it", {"MODELCHANGE"}},
        {"a mesh lists its nodes and elements: write them out",
         {"NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM"}}};
    const bool is_cyclic = keyword.is("TIE") && keyword.has("CYCLICSYMMETRY");
    const std::string cure = cure_of(all, is_cyclic ? "CYCLICSYMMETRYMODEL" : keyword.name);
    if (!cure.empty()) lines_.fail("*" + in_capitals(keyword.shown) + " found: " + cure);
  }

  void begin_constraint(const InpKeyword& keyword) {
    const std::string what = "*" + in_capitals(keyword.shown) + " ";
    const bool is_body = keyword.is("RIGIDBODY");
    std::string set = is_body ? "" : keyword.value("SURFACE");
    for (const char* nodes : {"NSET", "TIENSET", "PINNSET"})
      if (is_body && keyword.has(nodes)) set = keyword.value(nodes);
    if (is_body && (keyword.has("ELSET") || keyword.has("ANALYTICALSURFACE")))
      lines_.fail(what +
                  "of elements or of an analytical surface found: not in this version; use "
                  "instances.NAME.as: rigid for a whole part, walls for such a surface");
    for (const char* word : {"INFLUENCERADIUS", "ISOTHERMAL", "EXPLICIT"})
      if (keyword.has(word)) lines_.fail(what + "has " + word + ", which is not read: take it out");
    if (set.empty() || keyword.value("REFNODE").empty())
      lines_.fail(what + "without REF NODE=, and " +
                  (is_body ? "NSET=, TIE NSET= or PIN NSET=" : "SURFACE="));
    file_.constraints.push_back({in_capitals(keyword.value("REFNODE")),
                                 in_capitals(set),
                                 in_assembly_,
                                 is_body,
                                 is_body,
                                 {},
                                 lines_.place()});
  }

  void begin_motions(const InpKeyword& keyword) {
    if (file_.constraints.empty() || file_.constraints.back().is_complete)
      lines_.fail("*" + keyword.name + " without the *COUPLING before it");
    InpConstraint& of = file_.constraints.back();
    of.is_complete = true;
    of.rigid = keyword.is("KINEMATIC");
    for (const auto& [parameter, value] : keyword.values)
      if (in_capitals(value) != "UNIFORM" && in_capitals(value) != "CONTINUUM")
        lines_.fail("*" + keyword.name + ", " + parameter + (value.empty() ? "" : "=" + value) +
                    " found: not in this version; take it out, for equal shares of the area");
    take_ = [this, &of](const Fields& fields) {
      const Index first = lines_.whole(fields[0]),
                  last = fields.size() > 1 && !fields[1].empty() ? lines_.whole(fields[1]) : first;
      if (first < 1 || last > 6) lines_.fail("expected the first and the last motion, from 1 to 6");
      for (Index m = first; m <= last; ++m) of.motions[static_cast<std::size_t>(m) - 1] = true;
    };
  }

  // Of CalculiX: the node of the only element DCOUP3D in ELSET follows nodes and sets, each with
  // its weight.
  void begin_distribution(const InpKeyword& keyword) {
    const auto elset = file_.elsets.find(in_capitals(keyword.value("ELSET")));
    const auto element = elset == file_.elsets.end() || elset->second.ids.size() != 1
                             ? file_.point_elements.end()
                             : file_.point_elements.find(elset->second.ids.front());
    if (element == file_.point_elements.end() ||
        !file_.distributing_elements.contains(element->first))
      lines_.fail("*DISTRIBUTING COUPLING without ELSET= of one element DCOUP3D before it");
    const std::string name = "distributing_" + elset->second.name;
    set_ = &set_named(name, file_.nsets, file_.nset_order);
    generates_ = false;
    take_ = [this, first = std::optional<double>()](const Fields& fields) mutable {
      const double weight = fields.size() > 1 && !fields[1].empty() ? lines_.number(fields[1]) : 1;
      if (!(weight > 0))
        lines_.fail("weight " + std::string(fields[1]) + " found, expected above 0");
      if (weight != first.value_or(weight))
        lines_.fail("unequal weights found: not in this version; use equal ones");
      first = weight;
      take_ids({fields[0]}, file_.nsets);
    };
    file_.constraints.push_back({std::to_string(std::abs(element->second)),
                                 in_capitals(name),
                                 element->second < 0,
                                 false,
                                 true,
                                 {},
                                 lines_.place()});
  }

  // A mass, or I11, I22, I33, I12, I13, I23, the entries of the tensor.
  void begin_mass(const InpKeyword& keyword) {
    for (const char* word : {"ORIENTATION", "TYPE"})
      if (keyword.has(word))
        lines_.fail("*" + in_capitals(keyword.shown) + " has " + word +
                    ", expected the axes of the mesh: take it out");
    take_ = [this, is_mass = keyword.is("MASS"),
             elset = in_capitals(keyword.value("ELSET"))](const Fields& fields) {
      std::array<double, 6> x{};
      for (std::size_t i = 0; i < std::min(fields.size(), x.size()); ++i)
        if (!fields[i].empty()) x[i] = lines_.number(fields[i]);
      InpMass of{elset, is_mass ? x[0] : 0, Matrix3::Zero(), lines_.place()};
      if (!is_mass) of.inertia << x[0], x[3], x[4], x[3], x[1], x[5], x[4], x[5], x[2];
      file_.masses.push_back(of);
    };
  }

  void begin_nodes(const InpKeyword& keyword) {
    if (const std::string system = in_capitals(keyword.value("SYSTEM"));
        !system.empty() && system != "R")
      lines_.fail("SYSTEM=" + system + " found, expected rectangular coordinates (R)");
    take_ = [this](const Fields& fields) { take_node(fields); };
    const std::string name = keyword.value("NSET");
    set_ = !keyword.has("NSET") ? nullptr
           : in_assembly_       ? &file_.assembly_sets[in_capitals(name)]
                                : &set_named(name, file_.nsets, file_.nset_order);
  }

  void begin_elements(const InpKeyword& keyword) {
    const std::string word = in_capitals(keyword.value("TYPE"));
    const auto type = inp_type(word);
    static const std::vector<Instead> all = {
        {instead_of_points, {"DCOUP2D"}},
        {instead_of_springs, {"SPRINGA", "SPRING1", "SPRING2", "DASHPOTA", "DASHPOT1", "DASHPOT2"}},
        {instead_of_gaps, {"GAPUNI"}}};
    const std::string cure = cure_of(all, word);
    if (!type)
      lines_.fail(
          "element type '" + word + "' is not supported: " +
          (cure.empty()
               ? "use C3D4, C3D5, C3D6, C3D8, C3D10, C3D15 or C3D20 (with any letters after "
                 "them), shells for faces, and take the others out of the mesh"
               : cure));
    type_ = *type;
    is_distributing_ = word == "DCOUP3D";
    take_ = [this](const Fields& fields) { take_element(fields); };
    elset_ = keyword.value("ELSET");
    set_ = elset_.empty() ? nullptr : &set_named(elset_, file_.elsets, file_.elset_order);
  }

  void begin_set(const InpKeyword& keyword, const std::string& parameter,
                 std::map<std::string, InpSet>& sets, std::vector<std::string>& order) {
    if (keyword.value(parameter).empty())
      lines_.fail("*" + keyword.name + " without " + parameter + "=NAME");
    generates_ = keyword.has("GENERATE");
    if (in_assembly_ && !keyword.has("INSTANCE") && parameter == "NSET") {  // of reference points
      take_ = [this](const Fields& fields) { take_ids(fields, file_.assembly_sets); };
      set_ = &file_.assembly_sets[in_capitals(keyword.value(parameter))];
      return;
    }
    if (in_assembly_ && !keyword.has("INSTANCE")) return;
    take_ = [this, &sets](const Fields& fields) { take_ids(fields, sets); };
    set_ = &set_named(keyword.value(parameter), sets, order);
    set_->place = lines_.place();
    set_->internal = keyword.has("INTERNAL");
    if (parameter == "NSET" && keyword.has("ELSET"))
      set_->elsets.push_back(in_capitals(keyword.value("ELSET")));
  }

  void begin_surface(const InpKeyword& keyword) {
    const std::string type = in_capitals(keyword.value("TYPE"));
    if ((!type.empty() && type != "ELEMENT" && type != "NODE") || keyword.has("COMBINE"))
      lines_.fail(
          "a surface of elements' faces (TYPE=ELEMENT) or of nodes (TYPE=NODE) is expected");
    take_ = [this](const Fields& fields) { take_face(fields); };
    file_.surfaces.push_back({keyword.value("NAME"), type == "NODE", {}});
  }

  void begin_elastic(const InpKeyword& keyword) {
    const std::string type = in_capitals(without_blanks(keyword.value("TYPE")));
    take_ = [this](const Fields& fields) {
      take_constants(fields, has_elastic_,
                     {&material_->youngs_modulus, &material_->poissons_ratio});
    };
    if (type.starts_with("ENGINEERING")) {
      take_ = [this](const Fields& fields) { take_engineering_constants(fields); };
    } else if (!type.empty() && !type.starts_with("ISO")) {
      material_->problem = "is of *ELASTIC, TYPE=" + type;
      take_ = nullptr;
      has_elastic_ = true;
    }
  }

  void begin_orientation(const InpKeyword& keyword) {
    take_ = [this](const Fields& fields) { take_orientation(fields); };
    orientation_ = &file_.orientations[in_capitals(keyword.value("NAME"))];
    *orientation_ = {};
    n_lines_ = 0;
    for (const auto& [parameter, read] : {std::pair{"SYSTEM", "RC"}, {"DEFINITION", "C"}})
      if (const std::string word = in_capitals(keyword.value(parameter));
          !word.empty() && std::string(read).find(word[0]) == std::string::npos)
        leave_orientation("of " + std::string(parameter) + "=" + word);
    if (in_capitals(keyword.value("SYSTEM")).starts_with('C')) orientation_->center.emplace();
  }

  void leave_orientation(const std::string& what) {
    orientation_->problem = "has an *ORIENTATION " + what +
                            " (read are rectangular and cylindrical systems by points a and b)";
  }

  // a, b and, of Abaqus, their origin; then a rotation about one of the axes.
  void take_orientation(const Fields& fields) {
    if (!orientation_->problem.empty()) return;
    if (fields.size() == 1 && n_lines_ == 0) return leave_orientation("of a *DISTRIBUTION");
    std::array<double, 9> x{};
    for (std::size_t i = 0; i < std::min(fields.size(), x.size()); ++i)
      if (!fields[i].empty()) x[i] = lines_.number(fields[i]);
    if (++n_lines_ > 1) {
      if (x[1] != 0) leave_orientation("with a rotation about one of its axes");
      return;
    }
    if (fields.size() < 6) lines_.fail("expected the points a and b of *ORIENTATION: six numbers");
    const Vector3 origin(x[6], x[7], x[8]);
    orientation_->axis = Vector3(x[0], x[1], x[2]) - origin;
    orientation_->in_plane = Vector3(x[3], x[4], x[5]) - origin;
    if (!orientation_->center) return;
    // a and b are points of the cylinder's axis
    orientation_->center = orientation_->axis;
    orientation_->axis = orientation_->in_plane - orientation_->axis;
  }

  void take_engineering_constants(const Fields& fields) {
    if (has_elastic_) material_->problem = "depends on the temperature";
    for (const std::string_view field : fields) {
      if (has_elastic_ || field.empty()) continue;
      material_->engineering_constants.push_back(lines_.number(field));
      has_elastic_ = material_->engineering_constants.size() == 9;
    }
  }

  InpSet& set_named(const std::string& name, std::map<std::string, InpSet>& sets,
                    std::vector<std::string>& order) {
    const auto [found, is_new] = sets.try_emplace(in_capitals(name));
    if (is_new) {
      found->second.name = name;
      order.push_back(found->first);
    }
    return found->second;
  }

  void require_no_placement(const Fields& fields) const {
    for (const std::string_view field : fields)
      if (!field.empty() && lines_.number(field) != 0)
        lines_.fail(
            "an *INSTANCE that is moved: give the instance of the scene its position, and none "
            "here");
  }

  void take_node(const Fields& fields) {
    const Index id = lines_.whole(fields[0]);
    Vector3 at = Vector3::Zero();  // as is what is not given
    for (std::size_t c = 1; c <= 3 && c < fields.size(); ++c)
      if (!fields[c].empty()) at[static_cast<Index>(c) - 1] = lines_.number(fields[c]);
    if (set_ != nullptr) set_->ids.push_back(id);
    if (in_assembly_) {  // a reference point
      file_.assembly_nodes[id] = at;
      return;
    }
    file_.mesh.node_ids.push_back(id);
    file_.mesh.coordinates.insert(file_.mesh.coordinates.end(), at.begin(), at.end());
  }

  // Its number and nodes, over as many lines as it takes.
  void take_element(const Fields& fields) {
    for (const std::string_view field : fields)
      if (!field.empty()) pending_.push_back(lines_.whole(field));
    const std::size_t wanted = 1 + static_cast<std::size_t>(type_.n_nodes);
    if (pending_.size() < wanted) return;
    if (pending_.size() > wanted)
      lines_.fail(std::to_string(pending_.size() - 1) + " nodes found, expected " +
                  std::to_string(type_.n_nodes) +
                  ": give another TYPE, or take out those beyond, which CalculiX ignores");
    const Index id = pending_.front();
    pending_.erase(pending_.begin());
    if (set_ != nullptr) set_->ids.push_back(id);
    if (type_.n_nodes == 1) {
      file_.point_elements[id] = in_assembly_ ? -pending_.back() : pending_.back();
      if (is_distributing_) file_.distributing_elements.insert(id);
      pending_.clear();
      return;
    }
    if (!type_.type) {
      file_.lines[id] = std::exchange(pending_, {});
      return;
    }
    if (type_.is_plane) file_.plane_elements.insert(id);
    // Abaqus numbers the upper mid-edges before the upright ones, Exodus after them
    if (*type_.type == ElementType::hex20 || *type_.type == ElementType::wedge15) {
      const auto n = n_corners(*type_.type) / 2;
      std::swap_ranges(pending_.end() - n, pending_.end(), pending_.end() - 2 * n);
    }
    file_.mesh.elements.push_back(
        {id, *type_.type, file_.mesh.element_nodes.size(), elset_, type_.reduced});
    file_.mesh.element_nodes.insert(file_.mesh.element_nodes.end(), pending_.begin(),
                                    pending_.end());
    pending_.clear();
  }

  void require_whole_element() const {
    if (!pending_.empty())
      lines_.fail("element " + std::to_string(pending_.front()) + " before has too few nodes");
  }

  // Only such ends distinguish a whole file from one that is cut between two lines.
  void require_whole_file() const {
    const std::string cure = ": the file is cut short, export it again";
    if (!open_.empty()) lines_.fail("ends without *END " + open_.back() + cure);
    if (!waits_for_data_.empty())
      lines_.fail("ends after *" + waits_for_data_ + ", without its data" + cure);
  }

  // Steps are not read. *INCLUDE may hold their ends.
  void require_end_of_steps() {
    bool is_ended = false;
    while (lines_.next()) {
      const std::string line =
          in_capitals(without_blanks(std::string(trimmed(lines_.line()).substr(0, 40))));
      if (line.starts_with("*MODELCHANGE") && line.find("=CONTACT") == std::string::npos)
        refuse(lines_.keyword());
      if (line.starts_with("*ENDSTEP") || line.starts_with("*INCLUDE"))
        is_ended = true;
      else if (line.starts_with("*STEP"))
        is_ended = false;
    }
    if (!is_ended) lines_.fail("ends without *END STEP: the file is cut short, export it again");
  }

  static bool is_number(std::string_view field) {
    return !field.empty() && std::isdigit(static_cast<unsigned char>(field[0])) != 0;
  }

  void take_ids(const Fields& fields, const std::map<std::string, InpSet>& sets) {
    if (generates_) return take_range(fields);
    for (const std::string_view field : fields) {
      if (field.empty()) continue;
      const auto other = sets.find(in_capitals(unquoted(field)));
      if (other != sets.end() && &other->second != set_) {
        set_->ids.insert(set_->ids.end(), other->second.ids.begin(), other->second.ids.end());
      } else if (is_number(field)) {
        set_->ids.push_back(lines_.whole(field));
      } else {
        lines_.fail("no set '" + std::string(field) + "' before this line");
      }
    }
  }

  void take_range(const Fields& fields) {
    if (fields.size() < 2) lines_.fail("GENERATE expects first, last and step");
    const Index first = lines_.whole(fields[0]), last = lines_.whole(fields[1]);
    const Index step = fields.size() > 2 && !fields[2].empty() ? lines_.whole(fields[2]) : 1;
    if (step < 1 || last < first || (last - first) / step > most_generated)
      lines_.fail(
          "first, last and step of GENERATE expected, the last not below the first and the step "
          "from 1");
    for (Index id = first; id <= last; id += step) set_->ids.push_back(id);
  }

  void take_face(const Fields& fields) {
    std::string set = unquoted(fields[0]);
    if (n_instances_ > 0 && set.find('.') != std::string::npos) set = set.substr(set.find('.') + 1);
    InpSurface::Entry entry{in_capitals(set), 0,
                            fields.size() > 1 ? in_capitals(std::string(fields[1])) : "",
                            lines_.place()};
    if (is_number(set) && file_.elsets.count(entry.set) == 0 && file_.nsets.count(entry.set) == 0) {
      entry.id = lines_.whole(set);
      entry.set.clear();
    }
    file_.surfaces.back().entries.push_back(entry);
  }

  void take_constants(const Fields& fields, bool& is_known, const std::array<double*, 2>& targets) {
    if (is_known) {
      material_->problem = "depends on the temperature";
      return;
    }
    is_known = true;
    for (std::size_t i = 0; i < targets.size(); ++i)
      if (targets[i] != nullptr && i < fields.size() && !fields[i].empty())
        *targets[i] = lines_.number(fields[i]);
  }

  static constexpr Index most_generated = 100'000'000;

  DeckLines lines_;
  InpFile file_;
  Take take_;  // none: the data are skipped
  bool in_assembly_ = false, generates_ = false, has_elastic_ = false, has_density_ = false;
  int n_parts_ = 0, n_instances_ = 0, n_lines_ = 0;
  InpType type_;
  bool is_distributing_ = false;
  std::string elset_;
  std::vector<Index> pending_;     // number and nodes of an element that goes on in the next line
  std::vector<std::string> open_;  // *PART, *ASSEMBLY, *INSTANCE without their ends so far
  DroppedWords dropped_;
  std::string waits_for_data_;  // keyword of which no line of data has come
  InpSet* set_ = nullptr;
  FileMaterial *material_ = nullptr, *orientation_ = nullptr;
};

}  // namespace

InpFile read_inp(const std::filesystem::path& file) { return InpReader(file).run(); }

}  // namespace cbr
