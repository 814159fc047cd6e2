// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <sstream>

#include "common/base/error.hpp"
#include "common/scene/scene.hpp"
#include "tests/fuzz/scratch_folder.hpp"

namespace cbr::fuzz {
namespace {

std::string written(const Scene& scene) {
  std::ostringstream out;
  write_scene(scene, out);
  return out.str();
}

}  // namespace

void scene(Bytes bytes) {
  const ScratchFile file(".yaml", bytes);
  std::string text;
  try {
    const Scene first = read_scene(file.path().string());
    for (const auto& [name, material] : first.materials)
      require(std::isfinite(material.youngs_modulus + material.poissons_ratio + material.density),
              "a material is not finite");
    for (const Instance& instance : first.instances) {
      require(instance.position.allFinite() && instance.velocity.allFinite(),
              "an instance is not finite");
      require(instance.transformation().allFinite(), "an instance's rotation is not finite");
      component_of(first, instance);
    }
    text = written(first);
  } catch (const InputError&) {
    return;
  }
  const ScratchFile again(".yaml",
                          Bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
  const Scene second = read_scene(again.path().string());  // what a filter hands on is always read
  require(written(second) == text, "a scene changes when it is written and read");
}

}  // namespace cbr::fuzz
