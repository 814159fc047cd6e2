// SPDX-License-Identifier: GPL-3.0-or-later
#include <optional>

#include "common/base/error.hpp"
#include "tests/fuzz/hdf5_edits.hpp"
#include "tests/fuzz/read_superelement.hpp"
#include "tests/fuzz/run_scene.hpp"
#include "tests/fuzz/scratch_folder.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::fuzz {
namespace {

// A scene whose superelement is up to date, and that file's bytes.
struct SuperelementBase {
  Scene scene;
  std::string bytes;
};

SuperelementBase make_base(const std::string& name, const std::string& reduction) {
  const std::filesystem::path folder = scratch().path() / name;
  std::filesystem::create_directories(folder);
  Mesh mesh = test::block_mesh({{1, 1, 2}});
  mesh.nodesets.push_back({"clamp", 1, {0, 3}});
  write_mesh(mesh, folder / "block.exo");
  test::write_bytes(folder / "scene.yaml",
                    R"(materials: {rubber: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}
components:
  block: {mesh: block.exo, material: rubber, reduction: {interface: [z_min, z_max, clamp], )" +
                        reduction +
                        R"(, recovery: true}}
instances:
  a: {component: block, velocity: [0.1, 0, -1]}
  b: {component: block, position: [0.3, 0.2, 1.001], rotation: [10, 0, 0], mirror: x}
walls: {floor: {plane: {point: [0, 0, -0.001], normal: [0, 0, 1]}}}
contact: [{between: [a.z_min, floor], friction: 0.2}, {between: [a.z_max, b.z_min]}]
time: {end: 0.1, step: {cfl: 0.9}}
output: {history: [a.z_min]}
)");
  const Scene scene = reduced_scene((folder / "scene.yaml").string());
  return {scene, test::bytes_of(scene.components.at("block").reduction->superelement)};
}

const std::vector<SuperelementBase>& bases() {
  static const std::vector<SuperelementBase> list = {make_base("one", "modes: 5"),
                                         make_base("group", "modes: 3, domains: 2")};
  return list;
}

}  // namespace

void edits(Bytes bytes) {
  ByteSource source(bytes);
  const SuperelementBase& base = bases()[source.below(2)];
  const ScratchFile file(".cbr.h5", Bytes(reinterpret_cast<const std::uint8_t*>(base.bytes.data()),
                                          base.bytes.size()));
  edit_hdf5(file.path(), source);
  read_any_superelement(file.path());
  Scene scene = base.scene;
  scene.components.at("block").reduction->superelement = file.path();
  run_briefly(scene);
}

}  // namespace cbr::fuzz
