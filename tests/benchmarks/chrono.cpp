// SPDX-License-Identifier: GPL-3.0-or-later
// The parts of tests/cases/tumbling-parts as rigid bodies of Project Chrono, for peers.py:
//
//     peer-chrono BODIES ROWS nsc|smc STEP ENVELOPE ITERATIONS END EVERY
//
// BODIES: a row for each part with its centre of mass, quaternion, velocity and angular velocity.
// Constraints (nsc) or springs (smc). ROWS: every EVERY seconds time, momentum upwards, kinetic
// energy, common centre of mass. Without arguments it prints its version. To compile with Chrono's
// headers and core:
//
//     g++ -O2 -std=c++17 chrono.cpp -I PREFIX/include -I /usr/include/eigen3 -L PREFIX/lib
//     -lChrono_core -o peer-chrono
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include "chrono/ChVersion.h"
#include "chrono/collision/ChCollisionShapeBox.h"
#include "chrono/physics/ChBody.h"
#include "chrono/physics/ChSystemNSC.h"
#include "chrono/physics/ChSystemSMC.h"
#include "chrono/solver/ChIterativeSolverVI.h"

using namespace chrono;

namespace {

constexpr double kDensity = 1100, kModulus = 5e7, kPoisson = 0.4, kGravity = 9.81, kHalf = 0.33;
constexpr float kFriction = 0.4f, kRestitution = 0.5f;

struct Box {
  ChVector3d size, centre;
};

// Legs of 60 mm; centres from the centre of mass
const Box kLegs[] = {{{0.06, 0.02, 0.02}, {0.008, -0.012, 0}},
                     {{0.02, 0.04, 0.02}, {-0.012, 0.018, 0}}};

double mass(const Box& box) { return kDensity * box.size.x() * box.size.y() * box.size.z(); }

ChMatrix33<> inertia_of_legs() {
  ChMatrix33<> inertia;
  inertia.setZero();
  for (const Box& leg : kLegs) {
    const auto s = leg.size.eigen(), c = leg.centre.eigen();
    for (int i = 0; i < 3; ++i) {
      inertia(i, i) += mass(leg) * ((s.squaredNorm() - s(i) * s(i)) / 12 + c.squaredNorm());
      for (int j = 0; j < 3; ++j) inertia(i, j) -= mass(leg) * c(i) * c(j);
    }
  }
  return inertia;
}

void add_walls(ChSystem& system, const std::shared_ptr<ChContactMaterial>& material) {
  const Box walls[] = {{{2, 2, 0.2}, {0, 0, -0.1}},
                       {{0.2, 2, 2}, {-kHalf - 0.1, 0, 0}},
                       {{0.2, 2, 2}, {kHalf + 0.1, 0, 0}},
                       {{2, 0.2, 2}, {0, -kHalf - 0.1, 0}},
                       {{2, 0.2, 2}, {0, kHalf + 0.1, 0}}};
  auto room = chrono_types::make_shared<ChBody>();
  room->SetFixed(true);
  room->EnableCollision(true);
  for (const Box& wall : walls)
    room->AddCollisionShape(chrono_types::make_shared<ChCollisionShapeBox>(material, wall.size),
                            ChFrame<>(wall.centre));
  system.AddBody(room);
}

void add_parts(ChSystem& system, const std::shared_ptr<ChContactMaterial>& material,
               const char* file) {
  std::ifstream rows(file);
  ChVector3d x, v, w;
  ChQuaterniond q;
  while (rows >> x.x() >> x.y() >> x.z() >> q.e0() >> q.e1() >> q.e2() >> q.e3() >> v.x() >>
         v.y() >> v.z() >> w.x() >> w.y() >> w.z()) {
    auto part = chrono_types::make_shared<ChBody>();
    part->SetMass(mass(kLegs[0]) + mass(kLegs[1]));
    part->SetInertia(inertia_of_legs());
    part->SetPos(x);
    part->SetRot(q);
    part->SetPosDt(v);
    part->SetAngVelParent(w);
    part->EnableCollision(true);
    for (const Box& leg : kLegs)
      part->AddCollisionShape(chrono_types::make_shared<ChCollisionShapeBox>(material, leg.size),
                              ChFrame<>(leg.centre));
    system.AddBody(part);
  }
}

void write_state(const ChSystem& system, std::ofstream& rows) {
  double energy = 0, momentum = 0, mass = 0;
  ChVector3d centre(0, 0, 0);
  for (const auto& body : system.GetBodies()) {
    if (body->IsFixed()) continue;
    const ChVector3d v = body->GetPosDt(), w = body->GetAngVelLocal();
    energy += 0.5 * body->GetMass() * v.Length2() + 0.5 * w.Dot(body->GetInertia() * w);
    momentum += body->GetMass() * v.z();
    centre += body->GetMass() * body->GetPos();
    mass += body->GetMass();
  }
  rows << system.GetChTime() << ' ' << momentum << ' ' << energy << ' ' << centre.x() / mass << ' '
       << centre.y() / mass << ' ' << centre.z() / mass << '\n';
}

}  // namespace

int main(int n_words, char** words) {
  if (n_words != 9) {
    std::printf("%s\n", CHRONO_VERSION);
    return n_words == 1 ? 0 : 2;
  }
  const double step = std::atof(words[4]), end = std::atof(words[7]), every = std::atof(words[8]);
  std::shared_ptr<ChSystem> system;
  std::shared_ptr<ChContactMaterial> material;
  if (std::string(words[3]) == "smc") {
    auto springs = chrono_types::make_shared<ChContactMaterialSMC>();
    springs->SetYoungModulus(kModulus);
    springs->SetPoissonRatio(kPoisson);
    system = chrono_types::make_shared<ChSystemSMC>();
    material = springs;
  } else {
    system = chrono_types::make_shared<ChSystemNSC>();
    material = chrono_types::make_shared<ChContactMaterialNSC>();
    std::dynamic_pointer_cast<ChIterativeSolverVI>(system->GetSolver())
        ->SetMaxIterations(std::atoi(words[6]));
  }
  material->SetFriction(kFriction);
  material->SetRestitution(kRestitution);
  ChCollisionModel::SetDefaultSuggestedEnvelope(std::atof(words[5]));
  system->SetCollisionSystemType(ChCollisionSystem::Type::BULLET);
  system->SetGravitationalAcceleration({0, 0, -kGravity});
  add_walls(*system, material);
  add_parts(*system, material, words[1]);
  const int each = static_cast<int>(every / step + 0.5),
            n_steps = static_cast<int>(end / step + 0.5);
  std::ofstream rows(words[2]);
  rows.precision(12);
  write_state(*system, rows);
  for (int i = 1; i <= n_steps; ++i) {
    system->DoStepDynamics(step);
    if (i % each == 0) write_state(*system, rows);
  }
}
