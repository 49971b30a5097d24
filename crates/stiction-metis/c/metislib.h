/*
 * What the files of METIS in this folder need: the part of its headers and of GKlib that nested dissection uses. Written anew,
 * except for the two structures and the macros on lists and sums, which are METIS's.
 *
 * All files are compiled as one, nested_dissection.c; nothing but its one function has a name outside of it.
 */
#ifndef STICTION_METISLIB_H
#define STICTION_METISLIB_H

#include <float.h>
#include <limits.h>
#include <math.h>
#include <setjmp.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef int32_t idx_t;
typedef float real_t;
typedef ptrdiff_t place_t;
typedef int mdbglvl_et;

#define IDX_MAX INT32_MAX
#define REAL_MAX FLT_MAX
#define iabs abs
#define rabs fabsf

/* The options; METIS has more of each. */
enum { METIS_OP_PMETIS, METIS_OP_OMETIS };
enum { METIS_OBJTYPE_VOL, METIS_OBJTYPE_NODE };
enum { METIS_CTYPE_RM, METIS_CTYPE_SHEM };
enum { METIS_IPTYPE_EDGE, METIS_IPTYPE_NODE };
enum { METIS_RTYPE_SEP2SIDED, METIS_RTYPE_SEP1SIDED };

#define LTERM ((void **)0)
#define UNMATCHED -1
#define LARGENIPARTS 7
#define HTLENGTH ((1<<13)-1)
#define COARSEN_FRACTION 0.85
#define COMPRESSION_FRACTION 0.85
#define MMDSWITCH 120
#define OMETIS_DEFAULT_UFACTOR 200

#define gk_max(a, b) ((a) >= (b) ? (a) : (b))
#define gk_min(a, b) ((a) >= (b) ? (b) : (a))
#define SWAP(a, b, tmp) do {(tmp) = (a); (a) = (b); (b) = (tmp);} while(0)
#define INC_DEC(a, b, val) do {(a) += (val); (b) -= (val);} while(0)
#define I2RUBFACTOR(ufactor) (1.0+0.001*(ufactor))

#define MAKECSR(i, n, a) \
   do { \
     for (i=1; i<n; i++) a[i] += a[i-1]; \
     for (i=n; i>0; i--) a[i] = a[i-1]; \
     a[0] = 0; \
   } while(0)

#define SHIFTCSR(i, n, a) \
   do { \
     for (i=n; i>0; i--) a[i] = a[i-1]; \
     a[0] = 0; \
   } while(0)

#define BNDInsert(n, lind, lptr, i) \
   do { \
     lind[n] = i; \
     lptr[i] = (n)++;\
   } while(0)

#define BNDDelete(n, lind, lptr, i) \
   do { \
     lind[lptr[i]] = lind[--(n)]; \
     lptr[lind[n]] = lptr[i]; \
     lptr[i] = -1; \
   } while(0)

/* Nothing is printed, timed or checked at run time. */
#define IFSET(a, flag, cmd) do { } while (0);
#define ASSERT(expr) do { } while (0);
#define ASSERTP(expr, msg) do { } while (0);

/* Neighbours of a vertex on either side of a separator. */
typedef struct nrinfo_t {
  idx_t edegrees[2];
} nrinfo_t;

typedef struct graph_t {
  idx_t nvtxs, nedges;	/* The # of vertices and edges in the graph */
  idx_t ncon;		/* The # of constrains */
  idx_t *xadj;		/* Pointers to the locally stored vertices */
  idx_t *vwgt;		/* Vertex weights */
  idx_t *vsize;		/* Vertex sizes for min-volume formulation */
  idx_t *adjncy;        /* Array that stores the adjacency lists of nvtxs */
  idx_t *adjwgt;        /* Array that stores the weights of the adjacency lists */

  idx_t *tvwgt;         /* The sum of the vertex weights in the graph */
  real_t *invtvwgt;     /* The inverse of the sum of the vertex weights in the graph */

  /* These are to keep track control if the corresponding fields correspond to
     application or library memory */
  int free_xadj, free_vwgt, free_vsize, free_adjncy, free_adjwgt;

  idx_t *cmap;  /* The contraction/coarsening map */

  idx_t *label; /* The labels of the vertices for recursive bisection (pmetis/ometis) */

  /* Partition parameters */
  idx_t mincut, minvol;
  idx_t *where, *pwgts;
  idx_t nbnd;
  idx_t *bndptr, *bndind;

  /* Bisection refinement parameters */
  idx_t *id, *ed;

  /* K-way refinement: always NULL here */
  void *ckrinfo, *vkrinfo;

  /* Node refinement information */
  nrinfo_t *nrinfo;

  /* keep track of the dropped edgewgt */
  idx_t droppedewgt;

  /* the linked-list structure of the sequence of graphs */
  struct graph_t *coarser, *finer;
} graph_t;

typedef struct ctrl_t {
  int optype;           /* Type of operation */
  int objtype;          /* Type of refinement objective */
  int ctype;            /* The type of coarsening */
  int iptype;           /* The type of initial partitioning */
  int rtype;            /* The type of refinement */
  int dbglvl;           /* Always 0 here */

  idx_t CoarsenTo;      /* The # of vertices in the coarsest graph */
  idx_t no2hop;         /* Indicates if 2-hop matching will be used */
  idx_t nseps;          /* The number of separators to be found during multiple bisections */
  idx_t ufactor;        /* The user-supplied load imbalance factor */
  idx_t compress;       /* If the graph will be compressed prior to ordering */
  idx_t niter;          /* The number of iterations during each refinement */
  idx_t dropedges;      /* Indicates if edges will be randomly dropped during coarsening */
  idx_t *maxvwgt;       /* The maximum allowed weight for a vertex */

  real_t *ubfactors;    /*!< The per-constraint ubfactors */
  real_t *pijbm;        /*!< The nparts*ncon multiplies for the ith partition
                             and jth constraint for obtaining the balance */
} ctrl_t;

typedef struct {
  idx_t key, val;
} ikv_t;

typedef struct {
  real_t key;
  idx_t val;
} rkv_t;

/* A priority queue of vertices by gain. */
typedef struct {
  size_t nnodes, maxnodes;
  rkv_t *heap;
  place_t *locator;
} rpq_t;

/* support.c */
static void leave(int code);
static void *gk_malloc(size_t bytes, const char *what);
static void *gk_realloc(void *old, size_t bytes, const char *what);
static void gk_free(void **first, ...);
static void wspacepush(void);
static void wspacepop(void);
static void *wspacemalloc(size_t bytes);
static idx_t *iset(size_t n, idx_t value, idx_t *x);
static idx_t *icopy(size_t n, const idx_t *a, idx_t *b);
static idx_t isum(size_t n, const idx_t *x, size_t stride);
static idx_t *ismalloc(size_t n, idx_t value, const char *what);
static idx_t irandInRange(idx_t end);
static void irandArrayPermute(idx_t n, idx_t *p, idx_t shuffles, int fresh);
static void ikvsorti(size_t n, ikv_t *x);

#define imalloc(n, what) ((idx_t *)gk_malloc((size_t)(n) * sizeof(idx_t), what))
#define irealloc(old, n, what) ((idx_t *)gk_realloc(old, (size_t)(n) * sizeof(idx_t), what))
#define rmalloc(n, what) ((real_t *)gk_malloc((size_t)(n) * sizeof(real_t), what))
#define ikvmalloc(n, what) ((ikv_t *)gk_malloc((size_t)(n) * sizeof(ikv_t), what))
#define rkvmalloc(n, what) ((rkv_t *)gk_malloc((size_t)(n) * sizeof(rkv_t), what))
#define WCOREPUSH wspacepush()
#define WCOREPOP wspacepop()
#define iwspacemalloc(ctrl, n) ((idx_t *)wspacemalloc((size_t)(n) * sizeof(idx_t)))
#define ikvwspacemalloc(ctrl, n) ((ikv_t *)wspacemalloc((size_t)(n) * sizeof(ikv_t)))

/* queue.c */
static rpq_t *rpqCreate(size_t maxnodes);
static void rpqReset(rpq_t *queue);
static void rpqDestroy(rpq_t *queue);
static int rpqInsert(rpq_t *queue, idx_t node, real_t key);
static int rpqDelete(rpq_t *queue, idx_t node);
static void rpqUpdate(rpq_t *queue, idx_t node, real_t newkey);
static idx_t rpqGetTop(rpq_t *queue);
static idx_t rpqSeeTopVal(rpq_t *queue);

/* What the options above never reach: several weights a vertex, separators grown by vertices, edges left out, graphs on disk. */
#define ivecle(n, x, z) left_out()
#define ivecaxpylez(n, a, x, y, z) left_out()
#define BetterVBalance(ncon, invtvwgt, v, u1, u2) left_out()
#define FM_Mc2WayCutRefine(ctrl, graph, ntpwgts, niter) left_out()
#define McGeneral2WayBalance(ctrl, graph, ntpwgts) left_out()
#define GrowBisectionNode(ctrl, graph, ntpwgts, niparts) left_out()
#define isortd(n, base) left_out()
#define iaxpy(n, a, x, incx, y, incy) left_out()
#define gk_errexit(signal, ...) left_out()
#define graph_WriteToDisk(ctrl, graph) ((void)0)
#define graph_ReadFromDisk(ctrl, graph) ((void)0)
static int left_out(void);

/* The files of METIS. */
static void MlevelNestedDissection(ctrl_t *ctrl, graph_t *graph, idx_t *order, idx_t lastvtx);
static void MlevelNodeBisectionMultiple(ctrl_t *ctrl, graph_t *graph);
static void MlevelNodeBisectionL2(ctrl_t *ctrl, graph_t *graph, idx_t niparts);
static void MlevelNodeBisectionL1(ctrl_t *ctrl, graph_t *graph, idx_t niparts);
static void SplitGraphOrder(ctrl_t *ctrl, graph_t *graph, graph_t **r_lgraph, graph_t **r_rgraph);
static void MMDOrder(ctrl_t *ctrl, graph_t *graph, idx_t *order, idx_t lastvtx);
static graph_t *CoarsenGraph(ctrl_t *ctrl, graph_t *graph);
static graph_t *CoarsenGraphNlevels(ctrl_t *ctrl, graph_t *graph, idx_t nlevels);
static idx_t Match_RM(ctrl_t *ctrl, graph_t *graph);
static idx_t Match_SHEM(ctrl_t *ctrl, graph_t *graph);
static idx_t Match_2Hop(ctrl_t *ctrl, graph_t *graph, idx_t *perm, idx_t *match, idx_t cnvtxs, size_t nunmatched);
static idx_t Match_2HopAny(ctrl_t *ctrl, graph_t *graph, idx_t *perm, idx_t *match, idx_t cnvtxs, size_t *r_nunmatched, size_t maxdegree);
static idx_t Match_2HopAll(ctrl_t *ctrl, graph_t *graph, idx_t *perm, idx_t *match, idx_t cnvtxs, size_t *r_nunmatched, size_t maxdegree);
static void CreateCoarseGraph(ctrl_t *ctrl, graph_t *graph, idx_t cnvtxs, idx_t *match);
static graph_t *SetupCoarseGraph(graph_t *graph, idx_t cnvtxs, int dovsize);
static void ReAdjustMemory(ctrl_t *ctrl, graph_t *graph, graph_t *cgraph);
static graph_t *CompressGraph(ctrl_t *ctrl, idx_t nvtxs, idx_t *xadj, idx_t *adjncy, idx_t *vwgt, idx_t *cptr, idx_t *cind);
static void BucketSortKeysInc(ctrl_t *ctrl, idx_t n, idx_t max, idx_t *keys, idx_t *tperm, idx_t *perm);
static graph_t *SetupGraph(ctrl_t *ctrl, idx_t nvtxs, idx_t ncon, idx_t *xadj, idx_t *adjncy, idx_t *vwgt, idx_t *vsize, idx_t *adjwgt);
static void SetupGraph_tvwgt(graph_t *graph);
static void SetupGraph_label(graph_t *graph);
static graph_t *SetupSplitGraph(graph_t *graph, idx_t snvtxs, idx_t snedges);
static graph_t *CreateGraph(void);
static void InitGraph(graph_t *graph);
static void FreeSData(graph_t *graph);
static void FreeRData(graph_t *graph);
static void FreeGraph(graph_t **r_graph);
static void ConstructSeparator(ctrl_t *ctrl, graph_t *graph);
static void InitSeparator(ctrl_t *ctrl, graph_t *graph, idx_t niparts);
static void RandomBisection(ctrl_t *ctrl, graph_t *graph, real_t *ntpwgts, idx_t niparts);
static void GrowBisection(ctrl_t *ctrl, graph_t *graph, real_t *ntpwgts, idx_t niparts);
static void Allocate2WayPartitionMemory(ctrl_t *ctrl, graph_t *graph);
static void Compute2WayPartitionParams(ctrl_t *ctrl, graph_t *graph);
static void FM_2WayRefine(ctrl_t *ctrl, graph_t *graph, real_t *ntpwgts, idx_t niter);
static void FM_2WayCutRefine(ctrl_t *ctrl, graph_t *graph, real_t *ntpwgts, idx_t niter);
static void Balance2Way(ctrl_t *ctrl, graph_t *graph, real_t *ntpwgts);
static void Bnd2WayBalance(ctrl_t *ctrl, graph_t *graph, real_t *ntpwgts);
static void General2WayBalance(ctrl_t *ctrl, graph_t *graph, real_t *ntpwgts);
static void Refine2WayNode(ctrl_t *ctrl, graph_t *orggraph, graph_t *graph);
static void Allocate2WayNodePartitionMemory(ctrl_t *ctrl, graph_t *graph);
static void Compute2WayNodePartitionParams(ctrl_t *ctrl, graph_t *graph);
static void Project2WayNodePartition(ctrl_t *ctrl, graph_t *graph);
static void FM_2WayNodeRefine2Sided(ctrl_t *ctrl, graph_t *graph, idx_t niter);
static void FM_2WayNodeRefine1Sided(ctrl_t *ctrl, graph_t *graph, idx_t niter);
static void FM_2WayNodeBalance(ctrl_t *ctrl, graph_t *graph);
static real_t ComputeLoadImbalanceDiff(graph_t *graph, idx_t nparts, real_t *pijbm, real_t *ubvec);
static void Setup2WayBalMultipliers(ctrl_t *ctrl, graph_t *graph, real_t *tpwgts);
static void genmmd(idx_t, idx_t *, idx_t *, idx_t *, idx_t *, idx_t, idx_t *, idx_t *, idx_t *, idx_t *, idx_t, idx_t *);
static void mmdelm(idx_t, idx_t *, idx_t *, idx_t *, idx_t *, idx_t *, idx_t *, idx_t *, idx_t *, idx_t, idx_t);
static idx_t mmdint(idx_t, idx_t *, idx_t *, idx_t *, idx_t *, idx_t *, idx_t *, idx_t *, idx_t *);
static void mmdnum(idx_t, idx_t *, idx_t *, idx_t *);
static void mmdupd(idx_t, idx_t, idx_t *, idx_t *, idx_t, idx_t *, idx_t *, idx_t *, idx_t *, idx_t *, idx_t *, idx_t *, idx_t,
                   idx_t *);

#endif
