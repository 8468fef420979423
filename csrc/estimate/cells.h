/* Pixels that are divided in cells, each of which is sampled for itself, and is looked at again after each round: what
 * all estimators share that decide by cell, student-t, chi-squared, mitchell and kajiya.
 *
 * A pixel begins as cells x cells cells with `minimum` samples in all. A round then asks of every cell that is still
 * open whether the criterion is satisfied, and if not refines it in one of three ways. The estimate is the mean over
 * the pixel, each cell's mean weighted by its area.
 *
 * The criterion is asked of the cell's own samples, and where `margin` is above 0 also of them together with all others
 * that lie within `margin` times the distance between samples, sqrt(area / count), of the cell: those of the pixel so
 * far, and the first `minimum` ones of the eight pixels around it, which every pixel has whatever is decided. So few
 * first samples will do: an edge that they miss in a cell, as they all lie on one side, they meet beside it. The margin
 * shrinks as samples gather, and with it the number of cells that are refined for an edge beyond them.
 *
 * Where samples lie: the pixel's sequence goes on, and its points are skipped that fall in cells where no more are
 * wanted: those that are taken lie as evenly as those of a pixel that takes them all, and of a sequence whose points
 * are independent they are so too. A cell that was split has a run of its own, which begins at a multiple of a power of
 * two that is not shorter, so that of a net it is a net again, and whose points are moved into the cell. */
#ifndef ASC_CELLS_H
#define ASC_CELLS_H

#include "estimator.h"

typedef enum asc_refinement {
  ASC_ONE_BY_ONE,  /* `batch` times the number of cells more samples of the sequence, then the question again */
  ASC_ALL_AT_ONCE, /* all N of the sequence, and no further question */
  ASC_BY_SPLITTING /* `batch` more samples until it has `node`, then four cells in its place, which keep its samples */
} asc_refinement;

typedef struct asc_cells {
  asc_refinement refinement;
  uint32_t side;    /* cells, each way */
  uint64_t minimum; /* samples of a pixel before the first decision */
  uint64_t batch;
  uint64_t node;  /* samples of a cell after which it is split */
  uint32_t depth; /* how often a cell may be split */
  double margin;
  int unbiased; /* the samples decide only; as many fresh ones in each cell make the estimate */
} asc_cells;

#define ASC_CELLS_SIDE_MOST 8

/* One line of a table of parameters each. */
#define ASC_PARAMETER_CELLS(fallback)                                                                                  \
  { "cells", ASC_INTEGER, NULL, 1, ASC_CELLS_SIDE_MOST, fallback, "cells of a pixel each way, decided one by one" }
#define ASC_PARAMETER_MARGIN(fallback)                                                                                 \
  {                                                                                                                    \
    "margin", ASC_REAL, NULL, 0, 4, fallback,                                                                          \
        "how far around a cell samples count, in distances between samples; 0: its own alone"                          \
  }
#define ASC_PARAMETER_MINIMUM(least, fallback)                                                                         \
  { "minimum", ASC_INTEGER, NULL, least, 9007199254740992.0, fallback, "samples of a pixel before the first decision" }
#define ASC_PARAMETER_UNBIASED                                                                                         \
  { "unbiased", ASC_INTEGER, NULL, 0, 1, 0, "1: these samples decide only, as many fresh ones make the estimate" }

/* How far the criterion looks, in pixels. */
static inline uint32_t asc_cells_reach(double margin) { return margin > 0.0 ? 1 : 0; }

/* Checks the numbers, and makes what `unbiased` needs. */
asc_status asc_cells_prepare(asc_estimator *self, const asc_cells *how, asc_error *error);

asc_status asc_cells_run(const asc_estimator *self, const asc_cells *how, const asc_group *group,
                         asc_integrand integrand, void *context, asc_estimates *made, asc_error *error);

#endif
