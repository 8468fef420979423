/* Divide and conquer: the left half and the right half, then the edges between them from the bottom up.
 *
 * Source: Guibas and Stolfi 1985, "Primitives for the manipulation of general subdivisions and the computation of
 * Voronoi diagrams", section 9. Of their quad-edges the half that this needs: the edges, not their duals. */
#include "delaunay.h"

#include <stdlib.h>

/* The edges where two halves are joined: counterclockwise along the hull out of the leftmost place, and clockwise out
 * of the rightmost. */
typedef struct ends {
  uint32_t left, right;
} ends;

static int turn(const asc_delaunay *mesh, uint32_t a, uint32_t b, uint32_t c) {
  return asc_orientation(mesh->places[a], mesh->places[b], mesh->places[c]);
}

static int right_of(const asc_delaunay *mesh, uint32_t place, uint32_t edge) {
  return turn(mesh, place, asc_edge_end(mesh, edge), mesh->origin[edge]) > 0;
}

static int left_of(const asc_delaunay *mesh, uint32_t place, uint32_t edge) {
  return turn(mesh, place, mesh->origin[edge], asc_edge_end(mesh, edge)) > 0;
}

/* An edge that is joined to nothing. A planar graph has fewer than 3 n edges, for which there are slots. */
static uint32_t make_edge(asc_delaunay *mesh, uint32_t from, uint32_t to) {
  uint32_t edge = mesh->free;
  if (edge == ASC_NONE) {
    edge = mesh->edges;
    mesh->edges += 2;
  } else {
    mesh->free = mesh->next[edge];
  }
  mesh->origin[edge] = from;
  mesh->origin[edge ^ 1u] = to;
  mesh->next[edge] = mesh->before[edge] = edge;
  mesh->next[edge ^ 1u] = mesh->before[edge ^ 1u] = edge ^ 1u;
  return edge;
}

/* Puts `edge`, alone in its ring, after another in that one's ring. */
static void insert_after(asc_delaunay *mesh, uint32_t edge, uint32_t other) {
  const uint32_t following = mesh->next[other];
  mesh->next[other] = edge;
  mesh->before[edge] = other;
  mesh->next[edge] = following;
  mesh->before[following] = edge;
}

/* The next edge around the face on the left. */
static uint32_t along_left(const asc_delaunay *mesh, uint32_t edge) { return mesh->before[edge ^ 1u]; }

/* An edge from the end of `a` to the start of `b`, so that all three have one face on their left. */
static uint32_t connect(asc_delaunay *mesh, uint32_t a, uint32_t b) {
  const uint32_t edge = make_edge(mesh, asc_edge_end(mesh, a), mesh->origin[b]);
  insert_after(mesh, edge, along_left(mesh, a));
  insert_after(mesh, edge ^ 1u, b);
  return edge;
}

static void delete_edge(asc_delaunay *mesh, uint32_t edge) {
  for (uint32_t half = edge; half != ASC_NONE; half = half == edge ? edge ^ 1u : ASC_NONE) {
    mesh->next[mesh->before[half]] = mesh->next[half];
    mesh->before[mesh->next[half]] = mesh->before[half];
    mesh->origin[half] = ASC_NONE;
  }
  const uint32_t slot = edge & ~1u;
  mesh->next[slot] = mesh->free;
  mesh->free = slot;
}

static ends two(asc_delaunay *mesh, uint32_t begin) {
  const uint32_t edge = make_edge(mesh, begin, begin + 1);
  return (ends){edge, edge ^ 1u};
}

static ends three(asc_delaunay *mesh, uint32_t begin) {
  const uint32_t a = make_edge(mesh, begin, begin + 1), b = make_edge(mesh, begin + 1, begin + 2);
  insert_after(mesh, b, a ^ 1u);
  const int way = turn(mesh, begin, begin + 1, begin + 2);
  if (way == 0) return (ends){a, b ^ 1u};
  const uint32_t c = connect(mesh, b, a);
  return way > 0 ? (ends){a, b ^ 1u} : (ends){c ^ 1u, c};
}

static int inside(const asc_delaunay *mesh, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
  const asc_place *places = mesh->places;
  return asc_in_circle(places[a], places[b], places[c], places[d]) > 0;
}

/* The edge of the left half that the circle rising over `base` meets first; those that it shows not to be Delaunay's
 * are deleted. */
static uint32_t left_candidate(asc_delaunay *mesh, uint32_t base) {
  uint32_t edge = mesh->next[base ^ 1u];
  if (!right_of(mesh, asc_edge_end(mesh, edge), base)) return edge;
  while (inside(mesh, asc_edge_end(mesh, base), mesh->origin[base], asc_edge_end(mesh, edge),
                asc_edge_end(mesh, mesh->next[edge]))) {
    const uint32_t following = mesh->next[edge];
    delete_edge(mesh, edge);
    edge = following;
  }
  return edge;
}

static uint32_t right_candidate(asc_delaunay *mesh, uint32_t base) {
  uint32_t edge = mesh->before[base];
  if (!right_of(mesh, asc_edge_end(mesh, edge), base)) return edge;
  while (inside(mesh, asc_edge_end(mesh, base), mesh->origin[base], asc_edge_end(mesh, edge),
                asc_edge_end(mesh, mesh->before[edge]))) {
    const uint32_t following = mesh->before[edge];
    delete_edge(mesh, edge);
    edge = following;
  }
  return edge;
}

/* Joins a left and a right half, from the common tangent below to the one above. */
static ends join(asc_delaunay *mesh, ends on_left, ends on_right) {
  uint32_t left = on_left.right, right = on_right.left;
  for (;;) {
    if (left_of(mesh, mesh->origin[right], left))
      left = along_left(mesh, left);
    else if (right_of(mesh, mesh->origin[left], right))
      right = mesh->next[right ^ 1u]; /* the one before around the face on the right */
    else
      break;
  }
  uint32_t base = connect(mesh, right ^ 1u, left);
  if (mesh->origin[left] == mesh->origin[on_left.left]) on_left.left = base ^ 1u;
  if (mesh->origin[right] == mesh->origin[on_right.right]) on_right.right = base;
  for (;;) {
    const uint32_t a = left_candidate(mesh, base), b = right_candidate(mesh, base);
    const int a_above = right_of(mesh, asc_edge_end(mesh, a), base);
    const int b_above = right_of(mesh, asc_edge_end(mesh, b), base);
    if (!a_above && !b_above) return (ends){on_left.left, on_right.right};
    if (!a_above ||
        (b_above && inside(mesh, asc_edge_end(mesh, a), mesh->origin[a], mesh->origin[b], asc_edge_end(mesh, b))))
      base = connect(mesh, b, base ^ 1u);
    else
      base = connect(mesh, base ^ 1u, a ^ 1u);
  }
}

/* Halves, so it calls itself log2(count) deep at most. */
static ends triangulate(asc_delaunay *mesh, uint32_t begin, uint32_t count) {
  if (count == 2) return two(mesh, begin);
  if (count == 3) return three(mesh, begin);
  const ends left = triangulate(mesh, begin, count / 2);
  const ends right = triangulate(mesh, begin + count / 2, count - count / 2);
  return join(mesh, left, right);
}

asc_status asc_delaunay_create(const asc_place *places, size_t count, asc_delaunay *mesh) {
  const size_t slots = 6 * count;
  *mesh = (asc_delaunay){.places = places, .free = ASC_NONE};
  mesh->first = malloc(count * sizeof *mesh->first);
  mesh->origin = malloc(3 * slots * sizeof *mesh->origin);
  if (!mesh->first || !mesh->origin) {
    asc_delaunay_destroy(mesh);
    return ASC_OUT_OF_MEMORY;
  }
  mesh->next = mesh->origin + slots;
  mesh->before = mesh->next + slots;
  for (size_t i = 0; i < count; i++) mesh->first[i] = ASC_NONE;
  if (count > 1) (void)triangulate(mesh, 0, (uint32_t)count);
  for (uint32_t edge = mesh->edges; edge-- > 0;)
    if (mesh->origin[edge] != ASC_NONE) mesh->first[mesh->origin[edge]] = edge;
  return ASC_OK;
}

void asc_delaunay_destroy(asc_delaunay *mesh) {
  free(mesh->first);
  free(mesh->origin);
  *mesh = (asc_delaunay){0};
}
