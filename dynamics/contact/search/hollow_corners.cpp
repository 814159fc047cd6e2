// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/search/hollow_corners.hpp"

#include <algorithm>
#include <array>
#include <cmath>


namespace cbr {
namespace {

// Whether `second` constrains a node in addition to `first`, as in a concave corner. At a convex
// edge a node behind both faces entered through one of them. The other one is added only if the
// first does not resist the motion of this step.
bool holds_too(const DetectionStep& step, const FaceHit& first, const FaceHit& second) {
  if (!second.nearly_over || second.end_gap >= 0 ||
      second.end.normal.dot(first.end.normal) >= same_side)
    return false;
  const Vector3 between = centre(corners(step.master, second.face, step.master_body.end)) -
                          centre(corners(step.master, first.face, step.master_body.end));
  if (first.end.normal.dot(between) > 0 && second.end.normal.dot(between) < 0)
    return second.start_gap >= -step.options.kept_depth * step.master.sizes[second.face];
  return first.end_gap >= -1e-6 * step.master.sizes[first.face] &&
         second.start_gap >= 0.5 * second.end_gap;
}

// Where the faces found so far put a node back, and an orthonormal basis of the normals of the
// active ones, first entries.
struct Foothold {
  Vector3 at;
  std::array<Vector3, 3> directions;
  std::size_t n_directions = 0;
  std::span<const Vector3> all() const { return std::span(directions).first(n_directions); }
};

// Projection onto the intersection of their half-spaces, by Hildreth's successive projections.
void put_back(const SlaveNode& node, std::span<const FaceHit> holding, Foothold& foothold) {
  std::array<double, PairMemory::n_further + 1> push{};
  const std::size_t n = std::min(holding.size(), push.size());
  Vector3& x = foothold.at;
  x = node.end;
  for (int sweep = 0; sweep < (n > 1 ? 30 : 1); ++sweep)
    for (std::size_t i = 0; i < n; ++i) {
      const Vector3& normal = holding[i].end.normal;
      const double more = std::max(-push[i], -holding[i].end_gap - normal.dot(x - node.end));
      push[i] += more;
      x += more * normal;
    }
  foothold.n_directions = 0;
  for (std::size_t i = 0; i < n && foothold.n_directions < 3; ++i) {
    if (!(push[i] > 0)) continue;
    Vector3 direction = holding[i].end.normal;
    for (const Vector3& of : foothold.all()) direction -= of.dot(direction) * of;
    if (direction.norm() > 0.1)
      foothold.directions[foothold.n_directions++] = direction.normalized();
  }
}

// Whether a face that rises from the constraining faces constrains the node too; fills `hit`. The
// test is made at the corrected position, in front of the face or behind it. The faces that the
// node crossed do not matter. All faces act while the node is near all or behind all of them. So no
// force jumps when the node moves from one face to another.
bool holds_from_foot(const DetectionStep& step, const SlaveNode& node, const Foothold& foothold,
                     Index face, FaceHit& hit) {
  const bool triangle = is_triangle(step.master, face);
  const double size = step.master.sizes[face];
  const FaceCorners end = corners(step.master, face, step.master_body.end);
  const Projection ahead = project(end, triangle, foothold.at);
  if (!(size > 0) || ahead.normal.isZero()) return false;
  hit = {};
  hit.face = face;
  hit.end = project(end, triangle, node.end);
  if (std::min(ahead.distance, hit.end.distance) - node.lift > step.reach) return false;
  const FaceCorners start = corners(step.master, face, step.master_body.start);
  const Projection before = project(start, triangle, node.start);
  hit.start_gap = before.distance - node.lift;
  // A face and the one that it rises from are different, however flat they bend
  const auto is_this = [&](Index f) {
    return f == face ||
           (f >= 0 && !rises_from(step.master, face, f) && !rises_from(step.master, f, face) &&
            before.normal.dot(mean_normal(corners(step.master, f, step.master_body.start))) >=
                nearly_flat);
  };
  const bool touched =
      is_this(node.face) || std::any_of(node.further.begin(), node.further.end(), is_this);
  if (-hit.start_gap > (touched ? 1 : step.options.kept_depth) * size) return false;
  // Foot of the slope beside the node, or the corner with two other faces. The slope must not act
  // beyond its ends
  Vector3 along = ahead.normal;
  for (const Vector3& direction : foothold.all()) along -= direction.dot(along) * direction;
  const double slope = along.squaredNorm();
  const Vector3 foot =
      slope > 1e-3 ? Vector3(foothold.at - (ahead.distance / slope) * along) : foothold.at;
  const double edge = touched ? step.options.edge_tolerance : step.options.new_edge_tolerance;
  hit.outside = project(end, triangle, foot).outside;
  if (!(hit.outside <= edge)) return false;
  hit.nearly_over = hit.end.outside <= step.options.edge_tolerance;
  if (touched && before.outside <= edge) touch_where_it_is(before, end, node.end, hit.end);
  hit.end_gap = hit.end.distance - node.lift;
  return true;
}

// Order of the faces of a slope: first the one at the foot.
bool nearer_the_foot(const FaceHit& a, const FaceHit& b) {
  const double off_a = std::round(1e6 * std::max(0.0, a.outside)),
               off_b = std::round(1e6 * std::max(0.0, b.outside));
  return off_a != off_b ? off_a < off_b : a.end_gap < b.end_gap;
}

// Moves rising faces that constrain the node next to the first hit in `hits`. Each is tested
// together with those chosen so far: correction along one wall may lead into the next.
class RisingFaces {
 public:
  RisingFaces(const DetectionStep& step, const SlaveNode& node, std::vector<FaceHit>& hits)
      : step_(step), node_(node), hits_(hits) {
    const Index first = hits.front().face;
    const auto begin = step.master.rising.begin();
    faces_ = {begin + step.master.rising_begin[first], begin + step.master.rising_begin[first + 1]};
  }

  // Returns how many constrain the node.
  std::size_t choose() {
    FaceHit best;
    while (next(best) || next_of_two(best)) {
      std::erase_if(hits_, [&](const FaceHit& of) { return of.face == best.face; });
      hits_.insert(hits_.begin() + static_cast<std::ptrdiff_t>(n_held_), best);
      ++n_held_;
    }
    return n_held_;
  }

 private:
  bool fits_those_that_hold(const FaceHit& hit) const {
    const auto fits = [&](const FaceHit& other) {
      return other.face != hit.face &&
             (rises_from(step_.master, hit.face, other.face) || holds_too(step_, other, hit));
    };
    return std::all_of(hits_.begin(), hits_.begin() + static_cast<std::ptrdiff_t>(n_held_), fits);
  }

  // The best face at the position corrected by the chosen ones.
  bool next(FaceHit& best) {
    put_back(node_, std::span(hits_).first(n_held_), foothold_);
    bool any = false;
    for (const Index face : faces_) {
      if (!holds_from_foot(step_, node_, foothold_, face, hit_) || !fits_those_that_hold(hit_))
        continue;
      if (!any || nearer_the_foot(hit_, best)) {
        best = hit_;
        any = true;
      }
    }
    return any;
  }

  // For two walls crossed in one step. The uncorrected node passes each wall beyond the end of the
  // other. The position corrected by one is inside the other, and vice versa. Picks the best such
  // face.
  bool next_of_two(FaceHit& best) {
    thread_local std::vector<FaceHit> behind, holding;
    find_behind(behind);
    if (behind.size() < 2) return false;
    holding.assign(hits_.begin(), hits_.begin() + static_cast<std::ptrdiff_t>(n_held_));
    holding.emplace_back();
    // Whether `face` constrains the node after correction by `other`
    const auto holds_beside = [&](const FaceHit& other, Index face, FaceHit& hit) {
      holding.back() = other;
      put_back(node_, holding, foothold_);
      return holds_from_foot(step_, node_, foothold_, face, hit);
    };
    bool any = false;
    for (const FaceHit& one : behind)
      for (const FaceHit& other : behind) {
        if (!rises_from(step_.master, other.face, one.face) || !holds_beside(other, one.face, hit_))
          continue;
        if (!fits_those_that_hold(hit_) || !holds_beside(one, other.face, other_hit_)) continue;
        if (!any || nearer_the_foot(hit_, best)) {
          best = hit_;
          any = true;
        }
      }
    return any;
  }

  // Faces not chosen yet that the unconstrained node ends behind.
  void find_behind(std::vector<FaceHit>& behind) const {
    behind.clear();
    for (const Index face : faces_) {
      const auto is_this = [&](const FaceHit& of) { return of.face == face; };
      if (std::any_of(hits_.begin(), hits_.begin() + static_cast<std::ptrdiff_t>(n_held_), is_this))
        continue;
      FaceHit hit;
      hit.face = face;
      hit.end = project(corners(step_.master, face, step_.master_body.end),
                        is_triangle(step_.master, face), node_.end);
      hit.end_gap = hit.end.distance - node_.lift;
      if (hit.end_gap < 0) behind.push_back(hit);
    }
  }

  const DetectionStep& step_;
  const SlaveNode& node_;
  std::vector<FaceHit>& hits_;
  std::span<const Index> faces_;
  std::size_t n_held_ = 1;
  FaceHit hit_, other_hit_;
  Foothold foothold_;
};

}  // namespace

void touch_where_it_is(const Projection& now, const FaceCorners& end, const Vector3& x_end,
                       Projection& point) {
  point.normal = now.normal;
  point.weights = now.weights;
  Vector3 foot = Vector3::Zero();
  for (int a = 0; a < 4; ++a) foot += now.weights[a] * end[a];
  point.distance = now.normal.dot(x_end - foot);
}

bool rises_from(const ContactSurface& master, Index face, Index from) {
  if (master.rising.empty()) return false;
  const auto begin = master.rising.begin();
  const auto last = begin + master.rising_begin[from + 1];
  return std::find(begin + master.rising_begin[from], last, face) != last;
}

std::size_t choose_holding(const DetectionStep& step, const SlaveNode& node,
                           std::vector<FaceHit>& hits) {
  std::size_t n_held = step.master.rising.empty() ? 1 : RisingFaces(step, node, hits).choose();
  for (std::size_t i = n_held; i < hits.size(); ++i) {
    const auto also = [&](const FaceHit& other) { return holds_too(step, other, hits[i]); };
    if (std::all_of(hits.begin(), hits.begin() + static_cast<std::ptrdiff_t>(n_held), also))
      std::swap(hits[n_held++], hits[i]);
  }
  return n_held;
}

}  // namespace cbr
