#include "harness/scenes/obj/edge_crossings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <set>
#include <vector>

namespace stbvh::harness {
namespace {

bool is_before(Vec2 a, Vec2 b) {
  return a.x < b.x || (a.x == b.x && a.y < b.y);
}

struct Edge {
  Vec2 left, right;
};

/// On which side of an edge a point is: 1 left of it, -1 right of it, 0 on it within `rounding`.
int side_of(const Edge& edge, Vec2 p, double rounding) {
  const double area = doubled_area(edge.left, edge.right, p);
  const double least = rounding * std::hypot(edge.right.x - edge.left.x, edge.right.y - edge.left.y);
  return area > least ? 1 : area < -least ? -1 : 0;
}

bool cross(const Edge& a, const Edge& b, double rounding) {
  return side_of(a, b.left, rounding) * side_of(a, b.right, rounding) < 0 &&
         side_of(b, a.left, rounding) * side_of(b, a.right, rounding) < 0;
}

/// Order of edges that a vertical line meets, from below. The line stands at the later of their left ends.
struct Below {
  const std::vector<Edge>& edges;

  bool operator()(std::size_t i, std::size_t j) const {
    const Edge &a = edges[i], &b = edges[j];
    if (is_before(b.left, a.left)) return !is_above(b, a, i > j);
    return is_above(a, b, j > i);
  }

  /// Whether `later`, which begins last, is above `edge`.
  static bool is_above(const Edge& edge, const Edge& later, bool otherwise) {
    const double at_left = doubled_area(edge.left, edge.right, later.left);
    if (at_left != 0) return at_left > 0;
    const double at_right = doubled_area(edge.left, edge.right, later.right);
    return at_right != 0 ? at_right > 0 : otherwise;
  }
};

/// Those that have a length.
std::vector<Edge> edges_of(const Polygon& polygon) {
  std::vector<Edge> edges;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    if (is_before(a, b)) edges.push_back({a, b});
    if (is_before(b, a)) edges.push_back({b, a});
  }
  return edges;
}

/// An end of an edge.
struct Event {
  Vec2 at;
  bool begins;
  std::size_t edge;

  bool operator<(const Event& other) const {
    if (is_before(at, other.at) || is_before(other.at, at)) return is_before(at, other.at);
    return begins < other.begins;
  }
};

}  // namespace

bool crosses_itself(const Polygon& polygon) {
  const std::vector<Edge> edges = edges_of(polygon);
  const double rounding = rounding_of(polygon);
  std::vector<Event> events;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    events.push_back({edges[i].left, true, i});
    events.push_back({edges[i].right, false, i});
  }
  std::sort(events.begin(), events.end());
  using Status = std::set<std::size_t, Below>;
  Status status(Below{edges});
  std::vector<Status::iterator> places(edges.size(), status.end());
  const auto neighbours_cross = [&](Status::iterator lower, Status::iterator upper) {
    return lower != status.end() && upper != status.end() && cross(edges[*lower], edges[*upper], rounding);
  };
  const auto lower_neighbour = [&](Status::iterator place) {
    return place == status.begin() ? status.end() : std::prev(place);
  };
  for (const Event& event : events) {
    Status::iterator& place = places[event.edge];
    if (event.begins) {
      place = status.insert(event.edge).first;
      if (neighbours_cross(lower_neighbour(place), place) || neighbours_cross(place, std::next(place)))
        return true;
    } else {
      if (neighbours_cross(lower_neighbour(place), std::next(place))) return true;
      status.erase(place);
    }
  }
  return false;
}

}  // namespace stbvh::harness
