/*!
\file  gk_mkpqueue.h
\brief Templates for priority queues

\date   Started 4/09/07
\author George
\version\verbatim $Id: gk_mkpqueue.h 21742 2018-01-26 16:59:15Z karypis $ \endverbatim
*/

/* Of GKlib: its template, written out for vertices by real gains, the largest first. */

#include "metislib.h"

static void rpqInit(rpq_t *queue, size_t maxnodes);
static void rpqFree(rpq_t *queue);


/*************************************************************************/
/*! This function creates and initializes a priority queue */
/**************************************************************************/
rpq_t *rpqCreate(size_t maxnodes)
{
  rpq_t *queue;

  queue = (rpq_t *)gk_malloc(sizeof(rpq_t), "gk_pqCreate: queue");
  rpqInit(queue, maxnodes);

  return queue;
}


/*************************************************************************/
/*! This function initializes the data structures of the priority queue */
/**************************************************************************/
void rpqInit(rpq_t *queue, size_t maxnodes)
{
  size_t i;

  queue->nnodes = 0;
  queue->maxnodes = maxnodes;

  queue->heap    = rkvmalloc(maxnodes, "gk_PQInit: heap");
  queue->locator = (place_t *)gk_malloc(maxnodes*sizeof(place_t), "gk_PQInit: locator");
  for (i=0; i<maxnodes; i++)
    queue->locator[i] = -1;
}


/*************************************************************************/
/*! This function resets the priority queue */
/**************************************************************************/
void rpqReset(rpq_t *queue)
{
  place_t i;
  place_t *locator=queue->locator;
  rkv_t *heap=queue->heap;

  for (i=queue->nnodes-1; i>=0; i--)
    locator[heap[i].val] = -1;
  queue->nnodes = 0;
}


/*************************************************************************/
/*! This function frees the internal datastructures of the priority queue */
/**************************************************************************/
void rpqFree(rpq_t *queue)
{
  if (queue == NULL) return;
  gk_free((void **)&queue->heap, &queue->locator, LTERM);
  queue->maxnodes = 0;
}


/*************************************************************************/
/*! This function frees the internal datastructures of the priority queue
    and the queue itself */
/**************************************************************************/
void rpqDestroy(rpq_t *queue)
{
  if (queue == NULL) return;
  rpqFree(queue);
  gk_free((void **)&queue, LTERM);
}


/*************************************************************************/
/*! This function adds an item in the priority queue */
/**************************************************************************/
int rpqInsert(rpq_t *queue, idx_t node, real_t key)
{
  place_t i, j;
  place_t *locator=queue->locator;
  rkv_t *heap=queue->heap;

  i = queue->nnodes++;
  while (i > 0) {
    j = (i-1)>>1;
    if (key > heap[j].key) {
      heap[i] = heap[j];
      locator[heap[i].val] = i;
      i = j;
    }
    else
      break;
  }
  heap[i].key   = key;
  heap[i].val   = node;
  locator[node] = i;

  return 0;
}


/*************************************************************************/
/*! This function deletes an item from the priority queue */
/**************************************************************************/
int rpqDelete(rpq_t *queue, idx_t node)
{
  place_t i, j;
  size_t nnodes;
  real_t newkey, oldkey;
  place_t *locator=queue->locator;
  rkv_t *heap=queue->heap;

  i = locator[node];
  locator[node] = -1;

  if (--queue->nnodes > 0 && heap[queue->nnodes].val != node) {
    node   = heap[queue->nnodes].val;
    newkey = heap[queue->nnodes].key;
    oldkey = heap[i].key;

    if (newkey > oldkey) { /* Filter-up */
      while (i > 0) {
        j = (i-1)>>1;
        if (newkey > heap[j].key) {
          heap[i] = heap[j];
          locator[heap[i].val] = i;
          i = j;
        }
        else
          break;
      }
    }
    else { /* Filter down */
      nnodes = queue->nnodes;
      while ((j=(i<<1)+1) < nnodes) {
        if (heap[j].key > newkey) {
          if (j+1 < nnodes && heap[j+1].key > heap[j].key)
            j++;
          heap[i] = heap[j];
          locator[heap[i].val] = i;
          i = j;
        }
        else if (j+1 < nnodes && heap[j+1].key > newkey) {
          j++;
          heap[i] = heap[j];
          locator[heap[i].val] = i;
          i = j;
        }
        else
          break;
      }
    }

    heap[i].key   = newkey;
    heap[i].val   = node;
    locator[node] = i;
  }

  return 0;
}


/*************************************************************************/
/*! This function updates the key values associated for a particular item */
/**************************************************************************/
void rpqUpdate(rpq_t *queue, idx_t node, real_t newkey)
{
  place_t i, j;
  size_t nnodes;
  real_t oldkey;
  place_t *locator=queue->locator;
  rkv_t *heap=queue->heap;

  oldkey = heap[locator[node]].key;
  if (!(newkey > oldkey) && !(oldkey > newkey)) return;

  i = locator[node];

  if (newkey > oldkey) { /* Filter-up */
    while (i > 0) {
      j = (i-1)>>1;
      if (newkey > heap[j].key) {
        heap[i] = heap[j];
        locator[heap[i].val] = i;
        i = j;
      }
      else
        break;
    }
  }
  else { /* Filter down */
    nnodes = queue->nnodes;
    while ((j=(i<<1)+1) < nnodes) {
      if (heap[j].key > newkey) {
        if (j+1 < nnodes && heap[j+1].key > heap[j].key)
          j++;
        heap[i] = heap[j];
        locator[heap[i].val] = i;
        i = j;
      }
      else if (j+1 < nnodes && heap[j+1].key > newkey) {
        j++;
        heap[i] = heap[j];
        locator[heap[i].val] = i;
        i = j;
      }
      else
        break;
    }
  }

  heap[i].key   = newkey;
  heap[i].val   = node;
  locator[node] = i;

  return;
}


/*************************************************************************/
/*! This function returns the item at the top of the queue and removes
    it from the priority queue */
/**************************************************************************/
idx_t rpqGetTop(rpq_t *queue)
{
  place_t i, j;
  place_t *locator;
  rkv_t *heap;
  idx_t vtx, node;
  real_t key;

  if (queue->nnodes == 0)
    return -1;

  queue->nnodes--;

  heap    = queue->heap;
  locator = queue->locator;

  vtx = heap[0].val;
  locator[vtx] = -1;

  if ((i = queue->nnodes) > 0) {
    key  = heap[i].key;
    node = heap[i].val;
    i = 0;
    while ((j=2*i+1) < queue->nnodes) {
      if (heap[j].key > key) {
        if (j+1 < queue->nnodes && heap[j+1].key > heap[j].key)
          j = j+1;
        heap[i] = heap[j];
        locator[heap[i].val] = i;
        i = j;
      }
      else if (j+1 < queue->nnodes && heap[j+1].key > key) {
        j = j+1;
        heap[i] = heap[j];
        locator[heap[i].val] = i;
        i = j;
      }
      else
        break;
    }

    heap[i].key   = key;
    heap[i].val   = node;
    locator[node] = i;
  }
  return vtx;
}


/*************************************************************************/
/*! This function returns the item at the top of the queue. The item is not
    deleted from the queue. */
/**************************************************************************/
idx_t rpqSeeTopVal(rpq_t *queue)
{
  return (queue->nnodes == 0 ? -1 : queue->heap[0].val);
}
