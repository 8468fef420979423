#include "corners.h"

#include <stdlib.h>
#include <string.h>

/* Meshes of more triangles than polygons are cut into have such corners, but for rare ones; looking takes long. */
#define TRIANGLES_MOST 4096

typedef struct place {
  double of[3];
} place;

typedef struct edge {
  place ends[2]; /* in their order */
} edge;

static int compare_numbers(const double *a, const double *b, size_t count) {
  for (size_t i = 0; i < count; i++)
    if (a[i] != b[i]) return a[i] < b[i] ? -1 : 1;
  return 0;
}

static int compare_places(const void *a, const void *b) {
  return compare_numbers(((const place *)a)->of, ((const place *)b)->of, 3);
}

static int compare_edges(const void *a, const void *b) {
  const edge *first = a, *second = b;
  const int by_first = compare_places(&first->ends[0], &second->ends[0]);
  return by_first ? by_first : compare_places(&first->ends[1], &second->ends[1]);
}

static void list_edges(const asc_scene *scene, edge *edges) {
  for (size_t i = 0; i < 3 * scene->triangle_count; i++) {
    const size_t next = i % 3 == 2 ? i - 2 : i + 1;
    place a, b;
    memcpy(a.of, scene->vertices + 3 * i, sizeof a.of);
    memcpy(b.of, scene->vertices + 3 * next, sizeof b.of);
    const int in_order = compare_places(&a, &b) <= 0;
    edges[i].ends[0] = in_order ? a : b;
    edges[i].ends[1] = in_order ? b : a;
  }
}

/* The ends of sorted edges that one triangle alone has; gives how many. */
static size_t list_border(const edge *edges, size_t count, place *border) {
  size_t found = 0;
  for (size_t i = 0, end; i < count; i = end) {
    for (end = i + 1; end < count && compare_edges(&edges[i], &edges[end]) == 0;) end++;
    if (end > i + 1) continue;
    border[found++] = edges[i].ends[0];
    border[found++] = edges[i].ends[1];
  }
  return found;
}

int corners_any_surrounded(const asc_scene *scene) {
  const size_t count = 3 * scene->triangle_count;
  if (scene->triangle_count > TRIANGLES_MOST) return 1;
  if (count == 0) return 0;
  edge *edges = malloc(count * sizeof *edges);
  place *border = malloc(2 * count * sizeof *border);
  int any = !edges || !border;
  if (!any) {
    list_edges(scene, edges);
    qsort(edges, count, sizeof *edges, compare_edges);
    const size_t found = list_border(edges, count, border);
    qsort(border, found, sizeof *border, compare_places);
    for (size_t i = 0; i < 2 * count && !any; i++)
      any = !bsearch(&edges[i / 2].ends[i % 2], border, found, sizeof *border, compare_places);
  }
  free(edges);
  free(border);
  return any;
}
