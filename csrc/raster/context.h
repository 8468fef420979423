/* An OpenGL 4.5 core context without a window.
 *
 * Everything that knows OSMesa is in context.c: Mesa 25.1 dropped it, and EGL's surfaceless platform takes its place.
 * The rest of the raster sees OpenGL alone.
 */
#ifndef RASTER_CONTEXT_H
#define RASTER_CONTEXT_H

#include "aliascope/base.h"

typedef struct context context;

/* ASC_UNAVAILABLE where there is no context of OpenGL 4.5. */
asc_status context_create(context **made, asc_error *error);
void context_destroy(context *made);

/* Makes the context current in the calling thread; `context_leave` leaves the thread without one, so that the next
 * call may come from another thread. A context that the caller had current is lost. */
asc_status context_enter(context *made, asc_error *error);
void context_leave(void);

/* The address of an OpenGL function that libOSMesa has but does not export, or NULL. */
typedef void (*context_function)(void);
context_function context_address(const char *name);

#endif
