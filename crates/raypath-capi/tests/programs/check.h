/* Checks that end the program with a message. */
#ifndef CHECK_H
#define CHECK_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(condition)                                                                   \
  do {                                                                                     \
    if (!(condition)) {                                                                    \
      fprintf(stderr, "%s:%d: %s\n  last error: %s\n", __FILE__, __LINE__, #condition,     \
              raypath_last_error());                                                       \
      exit(1);                                                                             \
    }                                                                                      \
  } while (0)

/* A call that must fail with this status and a message that contains this text. */
#define CHECK_FAILS(call, status, text)                                                    \
  do {                                                                                     \
    const raypath_status found = (call);                                                   \
    if (found != (status) || strstr(raypath_last_error(), (text)) == NULL) {               \
      fprintf(stderr, "%s:%d: %s\n  status %d, message '%s'\n", __FILE__, __LINE__, #call, \
              (int)found, raypath_last_error());                                           \
      exit(1);                                                                             \
    }                                                                                      \
  } while (0)

/* Numbers from -1 to 1 that are the same in every run. */
static inline float next_random(uint32_t *state) {
  *state = *state * 1664525u + 1013904223u;
  return (float)((int32_t)*state) / 2147483648.0f;
}

#endif
