// Traces rays through the trees of boxes (bounding volume hierarchies) of render/scene_gpu/bvh.py: one over the
// instances of meshes, and below it one over the triangles of each mesh. The nearer child of a node is visited first,
// so that a hit there can skip the farther one.
//
// A point of a ray is start + distance * along. `along` goes one meter deeper along the camera's axis, so that a
// distance is a planar depth in meters, before and after an instance has turned the ray into its own axes.
//
// Include lib/scene.lib.glsl first and, with HOLES, lib/random.lib.glsl.
//
// Inputs
//   vertices         VERTEX_PARTS vec4 for each vertex: position and u, normal and v, with BUMPS tangent and its sign
//   triangles        x, y, z numbers of the vertices; w the triangle's number in its mesh, the order of drawing
//   nodes            all trees, one after the other
//   instance_trees   for each leaf of the tree over instances, its instance and the root of its mesh's tree
//   colors           with COLORS, rgba of each vertex
//   more_uvs         with PLACEMENTS, the second set of texture coordinates of each vertex

// NODE of bvh.py: a box from `low` to `high`.
//   count > 0   a leaf: `count` triangles from number `first` on, or one instance, instance_trees[first]
//   count < 0   children at `first` and `first` + 1, cut across the axis -1 - count, the lower one first
struct Node { vec3 low; int first; vec3 high; int count; };

// The axis across which the children of a node are cut.
int axis_of(Node node) { return -1 - node.count; }

struct InstanceTree { int instance; int root; };

layout(std430) readonly buffer vertices_block { vec4 vertices[]; };
layout(std430) readonly buffer triangles_block { uvec4 triangles[]; };
layout(std430) readonly buffer nodes_block { Node nodes[]; };
layout(std430) readonly buffer instance_trees_block { InstanceTree instance_trees[]; };
#ifdef COLORS
layout(std430) readonly buffer colors_block { uvec2 colors[]; };  // half floats
#endif
#ifdef PLACEMENTS
layout(std430) readonly buffer more_uvs_block { vec2 more_uvs[]; };
#endif
#ifdef HOLES
uvec3 ray_number;  // random state of the ray: alpha thresholds differ from ray to ray
#endif

#ifdef BUMPS
#define VERTEX_PARTS 3u
#else
#define VERTEX_PARTS 2u
#endif

#define STACK (BVH_DEPTH_MOST + 2)  // size of the stack of nodes yet to visit, more than the levels of a tree
#define SAME 1e-6                   // the relative rounding error of a distance

// The hit of a ray: its distance; an instance, -1 for none; a triangle, and the weights of its corners at the hit.
struct Hit { float distance; int instance; int triangle; vec3 weights; };

vec3 position_of(uint vertex) { return vertices[VERTEX_PARTS * vertex].xyz; }

Uv uv_of(uint vertex) {
    uint at = VERTEX_PARTS * vertex;
    vec2 first = vec2(vertices[at].w, vertices[at + 1u].w);
#ifdef PLACEMENTS
    return vec4(first, more_uvs[vertex]);
#else
    return first;
#endif
}

vec3 normal_of(uint vertex) { return vertices[VERTEX_PARTS * vertex + 1u].xyz; }

// The tangent at a hit, in world space, as in scene_mesh.vert.glsl: w is its sign; zeros without BUMPS.
vec4 tangent_at(int triangle, vec3 weights, mat3 to_world) {
#ifdef BUMPS
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 3; ++i) sum += weights[i] * vertices[3u * triangles[triangle][i] + 2u];
    return in_world(sum, to_world);
#else
    return vec4(0.0);
#endif
}

// The texture coordinates at a hit.
Uv uv_at(int triangle, vec3 weights) {
    uvec4 c = triangles[triangle];
#ifdef PLACEMENTS
    return mat3x4(uv_of(c.x), uv_of(c.y), uv_of(c.z)) * weights;
#else
    return mat3x2(uv_of(c.x), uv_of(c.y), uv_of(c.z)) * weights;
#endif
}

// The factor on the color at a hit, and its opacity in alpha, as in the rasterizer's lib/tint.lib.glsl.
vec4 tint_at(int triangle, vec3 weights) {
#ifdef COLORS
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 3; ++i) {
        uvec2 halves = colors[triangles[triangle][i]];
        sum += weights[i] * vec4(unpackHalf2x16(halves.x), unpackHalf2x16(halves.y));
    }
    return sum;
#else
    return vec4(1.0);
#endif
}

// True if a ray meets the box of a node between two distances. `inverse` is 1 / along. This is the slab test of Kay
// and Kajiya 1986, with the factor of Ize 2013, so that rounding misses no box.
bool hits_box(Node node, vec3 start, vec3 inverse, float nearest, float farthest) {
    vec3 a = (node.low - start) * inverse, b = (node.high - start) * inverse;
    vec3 in_at = min(a, b), out_at = max(a, b);
    float entry = max(max(in_at.x, in_at.y), max(in_at.z, nearest));
    float leave = min(min(out_at.x, out_at.y), out_at.z) * 1.0000004;
    return entry <= min(leave, farthest * (1.0 + SAME));
}

// Returns 1 / along, with large numbers in place of infinity, because infinity times 0 is NaN.
vec3 inverse_of(vec3 along) {
    vec3 least = mix(vec3(1e-20), vec3(-1e-20), lessThan(along, vec3(0.0)));
    return 1.0 / mix(along, least, lessThan(abs(along), vec3(1e-20)));
}

// The components of a vector, ordered so that axis `longest` comes last.
vec3 reorder_axes(vec3 v, int longest) {
    return longest == 0 ? v.yzx : longest == 1 ? v.zxy : v;
}

// The shear that turns the direction of a ray into its longest axis.
struct Shear { int longest; vec3 by; };

Shear shear_of(vec3 along) {
    vec3 a = abs(along);
    int longest = a.x > a.y && a.x > a.z ? 0 : a.y > a.z ? 1 : 2;
    vec3 t = reorder_axes(along, longest);
    return Shear(longest, vec3(t.xy, 1.0) / t.z);
}

vec3 shear_corner(vec3 corner, vec3 start, Shear shear) {
    vec3 p = reorder_axes(corner - start, shear.longest);
    return vec3(p.xy - shear.by.xy * p.z, shear.by.z * p.z);
}

// Intersects a ray with a triangle: xyz weights of the corners, w distance, which is -1 for a miss. By Woop, Benthin
// and Wald 2013: no ray slips through between two triangles that share an edge.
vec4 hit_triangle(uvec4 corners, vec3 start, Shear shear) {
    vec3 a = shear_corner(position_of(corners.x), start, shear);
    vec3 b = shear_corner(position_of(corners.y), start, shear);
    vec3 c = shear_corner(position_of(corners.z), start, shear);
    vec3 w = vec3(c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x);
    float sum = w.x + w.y + w.z;
    bool is_outside = any(lessThan(w, vec3(0.0))) && any(greaterThan(w, vec3(0.0)));
    if (is_outside || sum == 0.0) return vec4(-1.0);
    return vec4(w, dot(w, vec3(a.z, b.z, c.z))) / sum;
}

// True if a triangle at this distance is visible before a hit. Of two coincident surfaces the one drawn last is
// visible, as in the rasterizer.
bool is_before(float distance, int instance, int triangle, Hit hit) {
    if (hit.instance < 0) return distance < hit.distance;
    if (abs(distance - hit.distance) > SAME * distance) return distance < hit.distance;
    if (instance != hit.instance) return instance > hit.instance;
    return triangles[triangle].w > triangles[hit.triangle].w;
}

// Tests the triangles of a leaf, and keeps the nearest hit. With HOLES a triangle with a hole at this point is missed.
void intersect_leaf(Node leaf, int instance, vec3 start, Shear shear, float nearest, inout Hit hit) {
#ifdef HOLES
    uint material = instances[instance].numbers.x;
#endif
    for (int i = leaf.first; i < leaf.first + leaf.count; ++i) {
        vec4 candidate = hit_triangle(triangles[i], start, shear);
        if (candidate.w < nearest || !is_before(candidate.w, instance, i, hit)) continue;
#ifdef HOLES
        float threshold = random4(uvec4(ray_number, 4096u * uint(instance + 1) + uint(i))).w;
        if (is_hole(material, uv_at(i, candidate.xyz), tint_at(i, candidate.xyz).a, threshold)) continue;
#endif
        hit = Hit(candidate.w, instance, i, candidate.xyz);
    }
}

// Traces a ray through the mesh of an instance, in the instance's own axes.
void intersect_mesh(InstanceTree tree, vec3 world_start, vec3 world_along, float nearest, inout Hit hit) {
    mat4 to_object = instances[tree.instance].to_object;
    if (to_object[3][3] == 0.0) return;  // scaled to nothing
    vec3 start = (to_object * vec4(world_start, 1.0)).xyz;
    vec3 along = mat3(to_object) * world_along, inverse = inverse_of(along);
    Shear shear = shear_of(along);
    int stack[STACK], used = 0, at = tree.root;
    while (true) {
        Node node = nodes[at];
        bool is_met = hits_box(node, start, inverse, nearest, hit.distance);
        if (is_met && node.count < 0) {
            // against the axis the upper child is the nearer one; the farther one goes onto the stack
            int upper = int(along[axis_of(node)] < 0.0);
            at = node.first + upper;
            stack[used++] = node.first + 1 - upper;
            continue;
        }
        if (is_met) intersect_leaf(node, tree.instance, start, shear, nearest, hit);
        if (used == 0) return;
        at = stack[--used];
    }
}

// The first hit of a ray between two distances. `root` is the root of the tree over instances.
Hit first_hit(int root, vec3 start, vec3 along, float nearest, float farthest) {
    Hit hit = Hit(farthest, -1, -1, vec3(0.0));
    vec3 inverse = inverse_of(along);
    int stack[STACK], used = 0, at = root;
    while (true) {
        Node node = nodes[at];
        bool is_met = hits_box(node, start, inverse, nearest, hit.distance);
        if (is_met && node.count < 0) {
            // against the axis the upper child is the nearer one; the farther one goes onto the stack
            int upper = int(along[axis_of(node)] < 0.0);
            at = node.first + upper;
            stack[used++] = node.first + 1 - upper;
        } else {
            if (is_met) intersect_mesh(instance_trees[node.first], start, along, nearest, hit);
            if (used == 0) break;
            at = stack[--used];
        }
    }
    return hit;
}
