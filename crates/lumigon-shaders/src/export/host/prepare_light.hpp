// Prepares polygon lights for lumigon's shaders, on the host. C++17, nothing else.
//
// MIT or Apache-2.0, as you like.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace lumigon_host {

using Vector = std::array<double, 3>;

/// The shaders' PolygonLight, 64 bytes.
struct PolygonLight {
    float center[3];
    float inverse_radius;
    float normal[3];
    float doubled_area;
    float centroid[3];
    float plane_tolerance;
    float plane_axis[3];
    std::uint32_t both_sides;
};
static_assert(sizeof(PolygonLight) == 64, "shaders read 64 bytes");

/// A vertex in radii from its light's centre; the fourth number is 1 for a move, 0 for a line.
using Record = std::array<float, 4>;

namespace detail {

inline Vector operator+(Vector a, Vector b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vector operator-(Vector a, Vector b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vector operator*(Vector a, double f) { return {a[0] * f, a[1] * f, a[2] * f}; }
inline double dot(Vector a, Vector b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double length(Vector a) { return std::sqrt(dot(a, a)); }
inline Vector cross(Vector a, Vector b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Calls f(a, b) for every edge of every loop, the closing ones included.
template <typename F>
void for_edges(const std::vector<std::vector<Vector>>& loops, F f) {
    for (const auto& loop : loops) {
        for (std::size_t i = 0; i < loop.size(); i++) {
            f(loop[i], loop[(i + 1) % loop.size()]);
        }
    }
}

/// Calls f(v) for every vertex.
template <typename Loops, typename F>
void for_vertices(Loops& loops, F f) {
    for (auto& loop : loops) {
        for (auto& vertex : loop) {
            f(vertex);
        }
    }
}

/// Centroid of the signed area.
inline Vector centroid(const std::vector<std::vector<Vector>>& loops, Vector normal) {
    const Vector apex = loops[0][0];
    Vector sum = {0.0, 0.0, 0.0};
    double weight = 0.0;
    for_edges(loops, [&](Vector a, Vector b) {
        const double area = dot(cross(a - apex, b - apex), normal);
        sum = sum + (a + b + apex) * (area / 3.0);
        weight += area;
    });
    return sum * (1.0 / weight);
}

inline Vector farthest(const std::vector<std::vector<Vector>>& loops, Vector from) {
    Vector best = from;
    double best_distance = -1.0;
    for_vertices(loops, [&](const Vector& v) {
        const double distance = dot(v - from, v - from);
        if (distance > best_distance) {
            best = v;
            best_distance = distance;
        }
    });
    return best;
}

/// Centre of a circle around all vertices, at most 1 % larger than the smallest: from the middle of
/// two far ones, ever smaller steps towards the farthest (Badoiu and Clarkson, 2003).
inline Vector circle_center(const std::vector<std::vector<Vector>>& loops) {
    const Vector a = farthest(loops, loops[0][0]);
    const Vector b = farthest(loops, a);
    Vector center = (a + b) * 0.5;
    Vector best = center;
    double best_radius = std::numeric_limits<double>::infinity();
    for (int step = 0; step < 100; step++) {
        const Vector away = farthest(loops, center) - center;
        if (length(away) < best_radius) {
            best = center;
            best_radius = length(away);
        }
        center = center + away * (1.0 / (step + 2));
    }
    return best;
}

}  // namespace detail

/// A light from its loops in world space: outer ones counter-clockwise as seen from the emitting
/// side, holes clockwise. Its records go to the end of `records`.
///
/// Throws std::invalid_argument where the loops are no planar polygon with an area. They may leave
/// the plane by 1e-3 radii, and are moved onto it.
inline PolygonLight prepare_light(
    const std::vector<std::vector<Vector>>& world_loops, bool both_sides,
    std::vector<Record>& records) {
    using namespace detail;
    if (world_loops.empty()) {
        throw std::invalid_argument("a polygon light needs a loop");
    }
    for (std::size_t i = 0; i < world_loops.size(); i++) {
        const std::string place = "loop " + std::to_string(i);
        if (world_loops[i].size() < 3) {
            throw std::invalid_argument(place + ": a loop needs 3 vertices or more");
        }
        for (const Vector& v : world_loops[i]) {
            if (!std::isfinite(v[0]) || !std::isfinite(v[1]) || !std::isfinite(v[2])) {
                throw std::invalid_argument(place + ": a coordinate is not finite");
            }
        }
    }
    // Relative to a vertex, in units of the extent: far from the origin nothing is lost.
    const Vector origin = world_loops[0][0];
    auto loops = world_loops;
    double extent = 0.0;
    for_vertices(loops, [&](Vector& v) {
        v = v - origin;
        extent = std::max({extent, std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
    });
    if (!(extent > 1e-35 && extent < 1e35)) {
        throw std::invalid_argument("the polygon is too small or too large for single precision");
    }
    for_vertices(loops, [&](Vector& v) { v = v * (1.0 / extent); });
    Vector doubled = {0.0, 0.0, 0.0};
    for_edges(loops, [&](Vector a, Vector b) { doubled = doubled + cross(a, b); });
    if (!(length(doubled) > 1e-14)) {
        throw std::invalid_argument("the polygon has no area");
    }
    const Vector normal = doubled * (1.0 / length(doubled));
    const double plane = dot(normal, centroid(loops, normal));
    double off_plane = 0.0;
    for_vertices(loops, [&](Vector& v) {
        const double height = dot(normal, v) - plane;
        off_plane = std::max(off_plane, std::abs(height));
        v = v - normal * height;
    });
    const Vector center = circle_center(loops);
    const double radius = length(farthest(loops, center) - center);
    if (off_plane > 1e-3 * radius) {
        throw std::invalid_argument("the polygon is not planar: triangulate it");
    }
    for_vertices(loops, [&](Vector& v) { v = (v - center) * (1.0 / radius); });
    double doubled_area = 0.0;
    for_edges(loops, [&](Vector a, Vector b) { doubled_area += dot(cross(a, b), normal); });

    const Vector world_center = origin + center * extent;
    const double world_radius = radius * extent;
    const Vector middle = centroid(loops, normal);
    // Duff et al., "Building an Orthonormal Basis, Revisited", 2017.
    const double sign = normal[2] < 0.0 ? -1.0 : 1.0;
    const double a = -1.0 / (sign + normal[2]);
    const Vector axis = {
        sign * normal[0] * normal[0] * a + 1.0, sign * normal[0] * normal[1] * a, -sign * normal[0]};
    const double size =
        std::abs(world_center[0]) + std::abs(world_center[1]) + std::abs(world_center[2]);

    PolygonLight light;
    for (int i = 0; i < 3; i++) {
        light.center[i] = static_cast<float>(world_center[i]);
        light.normal[i] = static_cast<float>(normal[i]);
        light.centroid[i] = static_cast<float>(middle[i]);
        light.plane_axis[i] = static_cast<float>(axis[i]);
    }
    light.inverse_radius = static_cast<float>(1.0 / world_radius);
    light.doubled_area = static_cast<float>(doubled_area);
    // What rounding to single precision may move a point near the light.
    const double epsilon = std::numeric_limits<float>::epsilon();
    light.plane_tolerance = static_cast<float>(4.0 * epsilon * (1.0 + size / world_radius));
    light.both_sides = both_sides ? 1u : 0u;

    const auto record = [](Vector v, float start) {
        return Record{
            static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]), start};
    };
    for (const auto& loop : loops) {
        records.push_back(record(loop.back(), 1.0f));
        for (const Vector& v : loop) {
            records.push_back(record(v, 0.0f));
        }
    }
    return light;
}

}  // namespace lumigon_host
