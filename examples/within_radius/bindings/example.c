// A job of within_radius through libwithin_radius, which is libraypath with one operation more.
#include <raypath.h>
#include <stdio.h>
#include <string.h>

bool within_radius_add(void);

static uint64_t word(float number) {
  uint32_t bits;
  memcpy(&bits, &number, sizeof bits);
  return bits;
}

int main(void) {
  raypath_datapath *datapath;
  // A query point at the origin, the radius 2.5, and points at distances 1 to 4 on the x axis.
  const uint64_t job[16] = {[3] = word(2.5f), [4] = word(1), [7] = word(2), [10] = word(3), [13] = word(4)};
  uint64_t outcome[5];
  if (!within_radius_add()) {
    fprintf(stderr, "there is an operation within_radius\n");
    return 1;
  }
  if (raypath_open_with("", "within_radius", &datapath) != RAYPATH_OK ||
      raypath_run(datapath, "within_radius", job, 1, outcome) != RAYPATH_OK) {
    fprintf(stderr, "%s\n", raypath_last_error());
    return 1;
  }
  printf("near, as four bits: %x\n", (unsigned)outcome[0]);
  raypath_close(datapath);
  return 0;
}
