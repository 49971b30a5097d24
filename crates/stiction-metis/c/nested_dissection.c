/*
 * Nested dissection by METIS 5.2.1 (Karypis & Kumar 1998), all of it in this one file.
 */

#include "metislib.h"

#include "support.c"

#include "queue.c"

#include "balance.c"
#include "bucketsort.c"
#include "coarsen.c"
#include "compress.c"
#include "fm.c"
#include "graph.c"
#include "initpart.c"
#include "mcutil.c"
#include "mmd.c"
#include "ometis.c"
#include "options.c"
#include "refine.c"
#include "separator.c"
#include "sfm.c"
#include "srefine.c"

/* METIS_NodeND with its options as they are by default, other than `seed` and `separators`, which are those of METIS. */
static void order_nodes(idx_t n, idx_t *xadj, idx_t *adjncy, idx_t *vwgt, idx_t seed, idx_t separators, idx_t *perm, idx_t *iperm)
{
  ctrl_t *ctrl = (ctrl_t *)gk_malloc(sizeof(ctrl_t), "ctrl");
  graph_t *graph;
  idx_t *cptr, *cind;
  idx_t i, ii, j, l, nnvtxs = 0;

  memset(ctrl, 0, sizeof(ctrl_t));
  ctrl->optype    = METIS_OP_OMETIS;
  ctrl->objtype   = METIS_OBJTYPE_NODE;
  ctrl->rtype     = METIS_RTYPE_SEP1SIDED;
  ctrl->iptype    = METIS_IPTYPE_EDGE;
  ctrl->ctype     = METIS_CTYPE_SHEM;
  ctrl->nseps     = separators;
  ctrl->niter     = 10;
  ctrl->ufactor   = OMETIS_DEFAULT_UFACTOR;
  ctrl->compress  = 1;
  ctrl->CoarsenTo = 100;
  ctrl->maxvwgt   = ismalloc(1, 0, "maxvwgt");
  ctrl->ubfactors = rmalloc(1, "ubfactors");
  ctrl->ubfactors[0] = I2RUBFACTOR(ctrl->ufactor);
  ctrl->ubfactors[0] += 0.0000499;
  ctrl->pijbm = rmalloc(3, "pijbm");
  isrand((uint32_t)seed);

  cptr  = imalloc(n + 1, "cptr");
  cind  = imalloc(n, "cind");
  graph = CompressGraph(ctrl, n, xadj, adjncy, vwgt, cptr, cind);
  if (graph == NULL) {
    gk_free((void **)&cptr, &cind, LTERM);
    ctrl->compress = 0;
    graph = SetupGraph(ctrl, n, 1, xadj, adjncy, vwgt, NULL, NULL);
  }
  else {
    nnvtxs = graph->nvtxs;
    if (1.0 * n / nnvtxs > 1.5 && ctrl->nseps == 1)
      ctrl->nseps = 2;
  }

  run.core_size = 4 * ((size_t)graph->nvtxs + 1) * sizeof(idx_t) + 1024;
  run.core      = (char *)gk_malloc(run.core_size, "core");

  MlevelNestedDissection(ctrl, graph, iperm, graph->nvtxs);

  if (ctrl->compress) {
    for (i = 0; i < nnvtxs; i++)
      perm[iperm[i]] = i;
    for (l = ii = 0; ii < nnvtxs; ii++) {
      i = perm[ii];
      for (j = cptr[i]; j < cptr[i + 1]; j++)
        iperm[cind[j]] = l++;
    }
  }
  for (i = 0; i < n; i++)
    perm[iperm[i]] = i;
}

/*
 * Orders the `n` vertices of a symmetric graph without loops: `order[k]` is eliminated as the k-th and `place` is its inverse.
 * It holds `most_bytes` at most, and asks `stop` every few milliseconds. The result is one of the codes in support.c; unless it
 * is ORDERED, what is in `order` and `place` says nothing. No memory stays behind.
 */
int stiction_metis_nested_dissection(int32_t n, int32_t *start, int32_t *neighbours, int32_t *weights, int32_t seed,
                                     int32_t separators, size_t most_bytes, int (*stop)(const void *),
                                     const void *told_to_stop, int32_t *order, int32_t *place)
{
  memset(&run, 0, sizeof run);
  run.stop = stop;
  run.told_to_stop = told_to_stop;
  run.most_bytes = most_bytes;
  if (setjmp(run.landing) == 0)
    order_nodes(n, start, neighbours, weights, seed, separators, order, place);
  free_all();
  return run.code;
}
