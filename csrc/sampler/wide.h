/* Integers of 128 bits, where 64 would lose digits. */
#ifndef ASC_WIDE_H
#define ASC_WIDE_H

__extension__ typedef unsigned __int128 asc_wide; /* of GCC and Clang; not ISO C */

#endif
