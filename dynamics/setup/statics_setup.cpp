// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/build_steps.hpp"

#include <sstream>

#include "common/base/error.hpp"
#include "common/scene/scene_words.hpp"

namespace cbr {
namespace {

constexpr double usual_steps = 10, most_steps = 1e6;

void refuse_motion(const Scene& scene) {
  for (const Instance& instance : scene.instances)
    if (!instance.velocity.isZero(0))
      throw InputError(instance.source.text() + ": instance '" + instance.name +
                       "': velocity has no meaning with time: {static: true}: remove it");
}

// Static forces have no step to define a penalty stiffness.
void refuse_enforcement(const Scene& scene) {
  for (const ContactOptions& contact : scene.contact)
    if (contact.enforcement != Enforcement::impulse)
      throw InputError(contact.source.text() + ": contact: 'enforcement: " +
                       word_of(enforcement_words, contact.enforcement) +
                       "' is not available with statics (time.static, time.preload): use "
                       "'enforcement: impulse'");
}

void refuse_without_statics(const Scene& scene) {
  for (const ContactOptions& contact : scene.contact) {
    const bool pulls = contact.pretension_force || contact.shortening;
    if (!pulls && !contact.resolves_overlap && !(contact.interference > 0)) continue;
    throw InputError(contact.source.text() + ": contact: " +
                     (pulls                      ? "pretension"
                      : contact.resolves_overlap ? "overlap: resolve"
                                                 : "interference") +
                     " needs load steps of statics: remove time.preload, whose default are five, "
                     "or let it be 1 or more");
  }
}

}  // namespace

void check_statics(const Scene& scene) {
  const bool preloads = preload_steps(scene) > 0;
  if (!preloads) refuse_without_statics(scene);
  if (scene.time->is_static) refuse_motion(scene);
  if (scene.time->is_static || preloads) refuse_enforcement(scene);
}

Scene with_growing_loads(Scene scene) {
  for (Load& load : scene.loads)
    if (load.history.time.empty()) load.history = {{0, scene.time->end}, {0, 1}};
  return scene;
}

TimePlan plan_statics(const TimeOptions& time, double every) {
  const double h = time.step ? *time.step : time.end / usual_steps;
  if (time.end / h > most_steps) {
    std::ostringstream text;
    text << time.source.text() << ": time: " << time.end / h << " load steps, at most "
         << most_steps << " are allowed: take a longer time.step";
    throw InputError(text.str());
  }
  TimePlan plan = fit_steps(h, every, time.end);
  plan.limit = time.step ? "time.step" : "";
  return plan;
}

}  // namespace cbr
