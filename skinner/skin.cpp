// SPDX-License-Identifier: GPL-3.0-or-later
#include "skinner/skin.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <set>

#include "common/base/error.hpp"
#include "common/files/checked_files.hpp"
#include "common/files/output_file.hpp"
#include "common/mesh/face_weights.hpp"
#include "common/scene/component_blocks.hpp"
#include "common/scene/scene.hpp"
#include "common/scene/staleness.hpp"
#include "common/superelement/superelement.hpp"
#include "skinner/placed_mesh.hpp"

namespace cbr {
namespace {

ElementType shell_type(FaceKind kind) {
  switch (kind) {
    case FaceKind::tri3:
      return ElementType::tri3;
    case FaceKind::quad4:
      return ElementType::quad4;
    case FaceKind::tri6:
      return ElementType::tri6;
    case FaceKind::quad8:
      return ElementType::quad8;
    case FaceKind::quad9:
      return ElementType::quad9;
  }
  return ElementType::quad4;
}

std::vector<std::string> sideset_names(const Mesh& mesh) {
  std::vector<std::string> names;
  for (const auto& set : mesh.sidesets) names.push_back(set.name);
  return names;
}

SkinBlock add_block(Mesh& mesh, const IndexTable& faces, FaceKind kind, const std::string& name) {
  if (find_block(mesh, name) >= 0)
    throw InputError("the mesh has a block '" + name +
                     "' already: it has been skinned before; start from the mesh without a skin");
  Index id = 0, element = 0;
  for (const auto& other : mesh.blocks) {
    id = std::max(id, other.id);
    for (const Index e : other.element_ids) element = std::max(element, e);
  }
  // In a .msh file shells and sidesets share their numbers.
  for (const auto& set : mesh.sidesets) id = std::max(id, set.id);
  Block block{name, id + 1, shell_type(kind), faces, {}};
  for (Index f = 0; f < faces.rows(); ++f) block.element_ids.push_back(++element);
  mesh.blocks.push_back(std::move(block));
  const std::set<Index> nodes(faces.data(), faces.data() + faces.size());
  return {name, kind, faces.rows(), static_cast<Index>(nodes.size())};
}

// What the scene says is on an instance: the surfaces to skin.
bool is_listed(const SkinOptions& skin, const std::string& instance, const std::string& surface) {
  return std::any_of(skin.surfaces.begin(), skin.surfaces.end(), [&](const std::string& name) {
    return name == surface || name == instance + "." + surface;
  });
}

// Nodes that the superelement of this component keeps, ascending.
std::vector<Index> interface_nodes(const Component& component, const Mesh& mesh,
                                   const std::string& instance) {
  if (!component.reduction)
    throw InputError(component.source.text() + ": component '" + component.name +
                     "' has no reduction, which instance '" + instance +
                     "' (as: superelement) needs: add reduction: {interface: [...], modes: ...}");
  std::set<Index> nodes;
  for (const auto& name : component.reduction->interface_sets) {
    try {
      const auto set = set_nodes(mesh, name);
      nodes.insert(set.begin(), set.end());
    } catch (const InputError& error) {
      throw InputError(component.reduction->source.text() + ": interface of component '" +
                       component.name + "': " + error.what());
    }
  }
  return {nodes.begin(), nodes.end()};
}

class SceneSkinner {
 public:
  explicit SceneSkinner(const Scene& scene) : scene_(scene), skin_(*scene.skin) {}

  SkinnedMesh run() {
    for (const auto& instance : scene_.instances) add(instance);
    if (!without_mesh_.empty() && without_mesh_.size() == scene_.instances.size())
      throw InputError(
          skin_.source.text() +
          ": skin: no instance has a mesh, as all components are superelements alone: " +
          "run cbr-dyn without cbr-skin, it adds the shells itself");
    for (const auto& name : skin_.surfaces)
      if (!found_.count(name) && !may_be_without_mesh(name)) refuse(name);
    SkinnedMesh result;
    result.mesh = std::move(system_.mesh());
    for (const auto& [name, surface] : surfaces_)
      for (auto& block : add_skin(result.mesh, surface, name))
        result.blocks.push_back(std::move(block));
    result.notes = std::move(notes_);
    result.left_out = std::move(left_out_);
    return result;
  }

 private:
  void add(const Instance& instance) {
    const Component& component = component_of(scene_, instance);
    if (!component.has_mesh) {
      without_mesh_.insert(instance.name);
      notes_.push_back("instance " + instance.name +
                       ": left out, because its component is a superelement without a mesh; " +
                       "cbr-dyn adds the shells to it");
      return;
    }
    auto& original = meshes_[component.name];
    if (original.coordinates.rows() == 0) {
      original = read_mesh(component.mesh);
      mark_shells(component, original);
    }
    if (const std::string blocks = left_out_blocks(original); !blocks.empty()) {
      refuse_left_out_blocks(component, original);
      left_out_[component.name] = blocks;
    }
    const Mesh placed = place(original, instance);
    std::vector<Index> row;  // of each node of `placed` in the part, or -1
    SystemMesh::Offsets offsets;
    if (instance.as == InstanceKind::superelement) {
      const auto nodes = interface_nodes(component, placed, instance.name);
      row.assign(placed.node_ids.size(), -1);
      for (std::size_t i = 0; i < nodes.size(); ++i)
        row[static_cast<std::size_t>(nodes[i])] = static_cast<Index>(i);
      Mesh source = placed;
      for (const auto& name : component.reduction->interface_sets)
        if (find_nodeset(source, name) < 0)
          source.nodesets.push_back({name, 0, set_nodes(placed, name)});
      offsets = system_.add(keep_nodes(source, nodes), instance.name);
    } else {
      for (Index i = 0; i < placed.coordinates.rows(); ++i) row.push_back(i);
      offsets = system_.add(placed, instance.name);
    }
    if (offsets.nodes > 0)
      notes_.push_back("instance " + instance.name + ": node ids raised by " +
                       std::to_string(offsets.nodes));
    if (offsets.elements > 0)
      notes_.push_back("instance " + instance.name + ": element ids raised by " +
                       std::to_string(offsets.elements));
    collect(instance, placed, row);
  }

  void collect(const Instance& instance, const Mesh& placed, const std::vector<Index>& row) {
    for (const auto& set : placed.sidesets) {
      there_are_.insert(set.name);
      if (!is_listed(skin_, instance.name, set.name)) continue;
      Surface surface = extract_surface(placed, set);
      if (surface.n_faces() == 0) continue;
      bool kept = true;
      for (Index& node : surface.faces.reshaped()) {
        kept = kept && row[static_cast<std::size_t>(node)] >= 0;
        node = system_.first_node() + row[static_cast<std::size_t>(node)];
      }
      if (!kept) {
        notes_.push_back(
            "instance " + instance.name + ": surface " + set.name +
            " is left out, because the superelement's interface does not keep all its nodes");
        continue;
      }
      found_.insert(set.name);
      found_.insert(instance.name + "." + set.name);
      surfaces_.emplace_back("skin." + instance.name + "." + set.name, std::move(surface));
    }
  }

  // A surface of a superelement file alone, which is not read here: cbr-dyn tells whether it has
  // it.
  bool may_be_without_mesh(const std::string& name) const {
    return there_are_.count(name) == 0 && std::any_of(without_mesh_.begin(), without_mesh_.end(),
                                                      [&](const std::string& instance) {
                                                        return name.starts_with(instance + ".") ||
                                                               without_instance(name);
                                                      });
  }
  // INSTANCE.SURFACE is of the instance alone.
  bool without_instance(const std::string& name) const {
    return std::none_of(
        scene_.instances.begin(), scene_.instances.end(),
        [&](const Instance& instance) { return name.starts_with(instance.name + "."); });
  }

  [[noreturn]] void refuse(const std::string& name) const {
    const std::vector<std::string> names(there_are_.begin(), there_are_.end());
    const bool exists = there_are_.count(name) > 0;
    throw InputError(skin_.source.text() + ": skin: surfaces: " +
                     (exists
                          ? "the interface of no superelement keeps all nodes of '" + name +
                                "': add it to reduction: interface"
                          : "no instance has a surface '" + name + "'" + nearest_name(name, names) +
                                " (available: " + (names.empty() ? "none" : join(names)) + ")"));
  }

  const Scene& scene_;
  const SkinOptions& skin_;
  SystemMesh system_;
  std::map<std::string, Mesh> meshes_;
  std::set<std::string> there_are_, found_, without_mesh_;  // the last: instances
  std::vector<std::pair<std::string, Surface>> surfaces_;   // block name, faces in the system mesh
  std::vector<std::string> notes_;
  std::map<std::string, std::string> left_out_;
};

void write(const SkinnedMesh& skinned, const std::filesystem::path& file, Report& report) {
  {
    const auto phase = report.phase("writing the mesh");
    write_mesh(skinned.mesh, file);
  }
  for (const auto& note : skinned.notes) report.line(note);
  for (const Block& block : skinned.mesh.blocks)
    if (block.reduced)
      report.warning(file.string() + ": cannot hold that block '" + block.name +
                     "' has reduced integration: give it element: reduced in a scene");
  for (const auto& block : skinned.blocks)
    report.line(block.name + ": " + std::to_string(block.n_shells) + " shells (" +
                std::string(name(block.kind)) + ") on " + std::to_string(block.n_nodes) + " nodes");
  report.line("written: " + file.string() + ", " + std::to_string(skinned.mesh.coordinates.rows()) +
              " nodes, " + std::to_string(skinned.mesh.blocks.size()) + " blocks");
  report.timings();
}

// What cbr-dyn refuses is a warning here: cbr-reduce may be run after cbr-skin, too.
void warn_of_stale_superelements(const Scene& scene, Report& report) {
  for (const auto& [name, component] : scene.components) {
    const bool used = std::any_of(scene.instances.begin(), scene.instances.end(),
                                  [&, &its_name = name](const Instance& instance) {
                                    return instance.as == InstanceKind::superelement &&
                                           instance.component == its_name;
                                  });
    if (!used || !component.reduction || !component.has_mesh ||
        !std::filesystem::exists(component.reduction->superelement))
      continue;
    if (read_content_hash(component.reduction->superelement) == content_hash(scene, component) &&
        !is_of_other_mass(component))
      continue;
    report.warning(component.source.text() + ": component '" + name + "': the superelement " +
                   component.reduction->superelement.string() +
                   " was not made from the present mesh, materials and reduction options (" +
                   stale_text(scene, component) + "), the skinned mesh is: run cbr-reduce " +
                   (scene.file == "-" ? "SCENE" : scene.file.string()));
  }
}

void skin_a_mesh(const SkinCommand& command, Report& report) {
  if (command.sidesets.empty())
    throw InputError(command.input + ": which sidesets? Give --sideset NAME, once for each");
  if (command.output.empty())
    throw InputError(command.input + ": where to? Give -o FILE.msh or -o FILE.exo");
  if (is_same_file(command.input, command.output))
    throw InputError(command.output.string() +
                     ": is the mesh to skin and would be overwritten: give -o another name");
  refuse_other_mesh(command.output, "the skinned mesh", "give -o another name");
  report.refuse_timings_at(command.output, "the skinned mesh");
  UnchangedFiles inputs;
  for (const auto& file : mesh_files(command.input)) inputs.add(file);
  SkinnedMesh skinned;
  {
    const auto phase = report.phase("reading the mesh");
    skinned.mesh = read_mesh(command.input);
  }
  try {
    const auto phase = report.phase("skinning");
    const std::string left_out = left_out_blocks(skinned.mesh);
    skinned = skin_mesh(std::move(skinned.mesh), command.sidesets);
    if (!left_out.empty())
      report.warning(command.input + ": " + left_out + ": cbr-reduce and cbr-dyn ignore shells");
  } catch (const InputError& error) {
    throw InputError(command.input + ": " + error.what());
  }
  inputs.check();
  write(skinned, command.output, report);
}

void skin_a_scene(const SkinCommand& command, std::ostream* scene_out, Report& report) {
  if (!command.sidesets.empty())
    throw InputError(command.input +
                     ": --sideset requires a mesh (.msh, .exo, .inp, .bdf, ...) as INPUT; in a "
                     "scene give skin: surfaces");
  Scene scene = read_scene(command.input);
  if (scene.skin) {
    if (!command.output.empty())
      scene.skin->mesh = std::filesystem::absolute(command.output).lexically_normal();
    if (!is_written_mesh_name(scene.skin->mesh))
      throw InputError(scene.skin->source.text() + ": skin: mesh: '" +
                       scene.skin->mesh.filename().string() +
                       "' found, a name that ends in .msh, .exo, .e or .g is wanted");
    for (const auto& [name, component] : scene.components)
      if (component.has_mesh && is_same_file(component.mesh, scene.skin->mesh))
        throw InputError(scene.skin->source.text() + ": skin: mesh: '" +
                         scene.skin->mesh.filename().string() + "' is the mesh of component '" +
                         name + "' and would be overwritten: give the skinned mesh another name");
    refuse_other_mesh(
        scene.skin->mesh, "the skinned mesh",
        command.output.empty() ? "give skin.mesh another name" : "give -o another name");
    report.refuse_timings_at(scene.skin->mesh, "the skinned mesh");
    UnchangedFiles inputs;
    for (const Instance& instance : scene.instances)
      if (const Component& component = component_of(scene, instance); component.has_mesh)
        for (const auto& file : mesh_files(component.mesh)) inputs.add(file);
    SkinnedMesh skinned;
    {
      const auto phase = report.phase("reading and skinning");
      skinned = skin_scene(scene);
      for (const auto& [component, blocks] : skinned.left_out)
        warn_of_left_out_blocks(scene.components.at(component), blocks, report);
      warn_of_stale_superelements(scene, report);
    }
    inputs.check();
    write(skinned, scene.skin->mesh, report);
  } else {
    if (!command.output.empty())
      throw InputError(command.input +
                       ": -o was given, and the scene has no skin: add skin: to the scene");
    report.line("the scene has no skin: passed on unchanged");
  }
  if (scene_out != nullptr) write_scene(scene, *scene_out);
}

}  // namespace

std::vector<SkinBlock> add_skin(Mesh& mesh, const Surface& surface, const std::string& block_name) {
  std::map<std::size_t, std::vector<std::vector<Index>>, std::greater<>> by_size;
  for (Index f = 0; f < surface.n_faces(); ++f) {
    const std::vector<Index> nodes = nodes_of_face(surface, f);
    by_size[nodes.size()].push_back(nodes);
  }
  std::vector<SkinBlock> blocks;
  for (const auto& [size, of_size] : by_size) {
    const auto kind = static_cast<FaceKind>(size);
    IndexTable faces(static_cast<Index>(of_size.size()), static_cast<Index>(size));
    for (Index f = 0; f < faces.rows(); ++f)
      for (Index a = 0; a < faces.cols(); ++a) faces(f, a) = of_size[f][a];
    blocks.push_back(
        add_block(mesh, faces, kind,
                  by_size.size() == 1 ? block_name : block_name + "_" + std::string(name(kind))));
  }
  return blocks;
}

SkinnedMesh skin_mesh(Mesh mesh, const std::vector<std::string>& sidesets) {
  SkinnedMesh result{std::move(mesh), {}, {}};
  std::set<Index> done;
  for (const auto& name : sidesets) {
    const Index found = find_sideset(result.mesh, name);
    const auto names = sideset_names(result.mesh);
    if (found < 0)
      throw InputError("the mesh has no sideset '" + name + "'" + nearest_name(name, names) +
                       " (available: " + (names.empty() ? "none" : join(names)) + ")");
    const Sideset& set = result.mesh.sidesets[static_cast<std::size_t>(found)];
    if (set.sides.empty())
      throw InputError("sideset '" + name + "' is empty: there is nothing to skin");
    if (!done.insert(found).second)
      throw InputError("sideset '" + name + "' is given twice: name each once");
    for (auto& block : add_skin(result.mesh, extract_surface(result.mesh, set), "skin." + set.name))
      result.blocks.push_back(block);
  }
  return result;
}

SkinnedMesh skin_scene(const Scene& scene) { return SceneSkinner(scene).run(); }

void run_skin(const SkinCommand& command, std::ostream* scene_out, Report& report) {
  is_mesh_name(command.input) ? skin_a_mesh(command, report)
                              : skin_a_scene(command, scene_out, report);
}

}  // namespace cbr
