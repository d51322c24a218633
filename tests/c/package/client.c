/* Says what it was built with, and codes a column of a stream. */
#include <stdio.h>

#include "flicr.h"

static uint64_t memory[FLICR_STREAM_WORDS(16, FLICR_CODER_SMALL, 0)];

static void count(void *context, const uint8_t *datagram, size_t len) {
  (void)datagram;
  *(size_t *)context += len;
}

int main(void) {
  flicr_grid_config config;
  flicr_context context;
  flicr_stream *stream;
  flicr_column column = {0, 0, 0};
  uint32_t counts[16] = {500, 600, 700};
  size_t bytes = 0;
  if (flicr_version() != FLICR_VERSION) return 1;
  if (flicr_grid_config_init(FLICR_SENSOR_VLP16, 1800, &config) != FLICR_STATUS_OK) return 2;
  if (flicr_context_init(config.step_m, 0, &context) != FLICR_STATUS_OK) return 3;
  if (flicr_stream_init_small(memory, sizeof memory, &config, &context, 0, &stream) != FLICR_STATUS_OK) return 4;
  if (flicr_stream_push_column(stream, &column, counts, 16, count, &bytes) != FLICR_STATUS_OK) return 5;
  if (flicr_stream_end_turn(stream, count, &bytes) != FLICR_STATUS_OK) return 6;
  printf("flicr %lu: %lu bytes\n", (unsigned long)FLICR_VERSION, (unsigned long)bytes);
  return bytes > 20 && bytes < 60 ? 0 : 7;
}
