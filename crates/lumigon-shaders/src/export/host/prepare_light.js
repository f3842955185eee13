// Prepares polygon lights for lumigon's shaders, on the host. An ES module without dependencies.
//
// MIT or Apache-2.0, as you like.

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const scale = (a, f) => [a[0] * f, a[1] * f, a[2] * f];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const length = (a) => Math.sqrt(dot(a, a));
const cross = (a, b) => [
    a[1] * b[2] - a[2] * b[1],
    a[2] * b[0] - a[0] * b[2],
    a[0] * b[1] - a[1] * b[0],
];

/** Every edge of every loop, the closing ones included. */
const edgesOf = (loops) =>
    loops.flatMap((loop) => loop.map((vertex, i) => [vertex, loop[(i + 1) % loop.length]]));

/** Centroid of the signed area. */
function centroidOf(loops, normal) {
    const apex = loops[0][0];
    let sum = [0, 0, 0];
    let weight = 0;
    for (const [a, b] of edgesOf(loops)) {
        const area = dot(cross(subtract(a, apex), subtract(b, apex)), normal);
        sum = add(sum, scale(add(add(a, b), apex), area / 3));
        weight += area;
    }
    return scale(sum, 1 / weight);
}

function farthestOf(vertices, from) {
    let best = from;
    let bestDistance = -1;
    for (const vertex of vertices) {
        const away = subtract(vertex, from);
        const distance = dot(away, away);
        if (distance > bestDistance) {
            best = vertex;
            bestDistance = distance;
        }
    }
    return best;
}

/**
 * Centre of a circle around all vertices, at most 1 % larger than the smallest: from the middle of two
 * far ones, ever smaller steps towards the farthest (Badoiu and Clarkson, 2003).
 */
function circleCenterOf(vertices) {
    const a = farthestOf(vertices, vertices[0]);
    const b = farthestOf(vertices, a);
    let center = scale(add(a, b), 0.5);
    let best = center;
    let bestRadius = Infinity;
    for (let step = 0; step < 100; step++) {
        const away = subtract(farthestOf(vertices, center), center);
        if (length(away) < bestRadius) {
            best = center;
            bestRadius = length(away);
        }
        center = add(center, scale(away, 1 / (step + 2)));
    }
    return best;
}

/**
 * A light from its loops in world space, each an array of [x, y, z]: outer ones counter-clockwise as
 * seen from the emitting side, holes clockwise.
 *
 * Returns the fields of the shaders' PolygonLight as numbers and arrays, `bytes`, the same as an
 * ArrayBuffer of 64 bytes for storage and uniform buffers, and `records`, a Float32Array with four
 * numbers a record: a vertex in radii from the light's centre, then 1 for a move, 0 for a line.
 *
 * Throws a RangeError where the loops are no planar polygon with an area. They may leave the plane
 * by 1e-3 radii, and are moved onto it.
 */
export function prepareLight(worldLoops, bothSides = false) {
    if (worldLoops.length === 0) {
        throw new RangeError("a polygon light needs a loop");
    }
    worldLoops.forEach((loop, i) => {
        if (loop.length < 3) {
            throw new RangeError(`loop ${i}: a loop needs 3 vertices or more`);
        }
        if (!loop.every((v) => v.length === 3 && v.every(Number.isFinite))) {
            throw new RangeError(`loop ${i}: a vertex is not three finite numbers`);
        }
    });
    // Relative to a vertex, in units of the extent: far from the origin nothing is lost.
    const origin = worldLoops[0][0];
    const mapped = (loops, f) => loops.map((loop) => loop.map(f));
    let loops = mapped(worldLoops, (v) => subtract(v, origin));
    const extent = loops.flat(2).reduce((most, x) => Math.max(most, Math.abs(x)), 0);
    if (!(extent > 1e-35 && extent < 1e35)) {
        throw new RangeError("the polygon is too small or too large for single precision");
    }
    loops = mapped(loops, (v) => scale(v, 1 / extent));
    const doubled = edgesOf(loops).reduce((sum, [a, b]) => add(sum, cross(a, b)), [0, 0, 0]);
    if (!(length(doubled) > 1e-14)) {
        throw new RangeError("the polygon has no area");
    }
    const normal = scale(doubled, 1 / length(doubled));
    const plane = dot(normal, centroidOf(loops, normal));
    const offPlane = Math.max(...loops.flat().map((v) => Math.abs(dot(normal, v) - plane)));
    loops = mapped(loops, (v) => subtract(v, scale(normal, dot(normal, v) - plane)));
    const center = circleCenterOf(loops.flat());
    const radius = length(subtract(farthestOf(loops.flat(), center), center));
    if (offPlane > 1e-3 * radius) {
        throw new RangeError("the polygon is not planar: triangulate it");
    }
    loops = mapped(loops, (v) => scale(subtract(v, center), 1 / radius));

    const worldCenter = add(origin, scale(center, extent));
    const worldRadius = radius * extent;
    // Duff et al., "Building an Orthonormal Basis, Revisited", 2017.
    const [x, y, z] = normal;
    const sign = z < 0 ? -1 : 1;
    const a = -1 / (sign + z);
    const size = worldCenter.reduce((sum, c) => sum + Math.abs(c), 0);
    const light = {
        center: worldCenter,
        inverse_radius: 1 / worldRadius,
        normal,
        doubled_area: edgesOf(loops).reduce((sum, [p, q]) => sum + dot(cross(p, q), normal), 0),
        centroid: centroidOf(loops, normal),
        // What rounding to single precision may move a point near the light.
        plane_tolerance: 4 * 2 ** -23 * (1 + size / worldRadius),
        plane_axis: [sign * x * x * a + 1, sign * x * y * a, -sign * x],
        both_sides: bothSides ? 1 : 0,
    };
    light.bytes = new ArrayBuffer(64);
    new Float32Array(light.bytes).set([
        ...light.center,
        light.inverse_radius,
        ...light.normal,
        light.doubled_area,
        ...light.centroid,
        light.plane_tolerance,
        ...light.plane_axis,
    ]);
    new Uint32Array(light.bytes)[15] = light.both_sides;
    light.records = new Float32Array(
        loops.flatMap((loop) => [
            [...loop.at(-1), 1],
            ...loop.map((v) => [...v, 0]),
        ]).flat(),
    );
    return light;
}
