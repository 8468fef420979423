/* The GLSL that programs are put together from, by the macros that say which they are: see shaders.c. */
#ifndef RASTER_SHADER_TEXT_H
#define RASTER_SHADER_TEXT_H

extern const char text_version[];
extern const char text_blocks[];
extern const char text_vertex[];
extern const char text_inputs[];
/* What the ray through a place in the picture meets, and the normal there. */
extern const char text_flat[];   /* triangles, discs, planes */
extern const char text_sphere[]; /* spheres */
extern const char text_zone_plate[];
extern const char text_checker[];
extern const char text_shadow[];
extern const char text_sphere_light[];
extern const char text_light[];
extern const char text_main[];

#endif
