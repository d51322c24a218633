/*
 * A VLP-16's packets into flicr frames, from C, a frame for each turn; and returns that a driver has already read.
 *
 *     tools/staticlib.sh x86_64-unknown-linux-gnu        (prints where the library lies)
 *     cc -std=c99 -Iinclude examples/c/packets.c LIBRARY -o packets
 *     ./packets OUT_PREFIX PACKETS
 *
 * PACKETS holds UDP payloads, each behind its length in two bytes, low byte first. Frames are written one behind the
 * other to OUT_PREFIX-packets.flicr; those of made-up returns of an HDL-64E to OUT_PREFIX-returns.flicr.
 */
#include <stdio.h>
#include <stdlib.h>

#include "flicr.h"

#define COLUMNS 1800
#define BEAMS 16
#define LEVEL_BITS 16
#define TICKS 4000
#define ROWS 64
#define PACKET_MAX 1300

/* All memory that flicr needs, sized at compile time. */
static uint64_t packet_encoder[FLICR_GRID_ENCODER_WORDS(COLUMNS, BEAMS, LEVEL_BITS, FLICR_CODER_RLE)];
static uint64_t return_encoder[FLICR_GRID_ENCODER_WORDS(TICKS, ROWS, 8, FLICR_CODER_DEFLATE_SMALL)];
static uint8_t packet_frame[FLICR_GRID_WORST_CASE_LEN(COLUMNS, BEAMS, LEVEL_BITS, FLICR_CODER_RLE)];
static uint8_t return_frame[FLICR_GRID_WORST_CASE_LEN(TICKS, ROWS, 8, FLICR_CODER_DEFLATE_SMALL)];

static void fail(const char *what, const char *why) {
  fprintf(stderr, "%s: %s\n", what, why);
  exit(1);
}

static void check(const char *what, flicr_status status) {
  if (status != FLICR_STATUS_OK) fail(what, flicr_status_text(status));
}

static FILE *open_or_fail(const char *path, const char *mode) {
  FILE *file = fopen(path, mode);
  if (!file) fail(path, "cannot be opened");
  return file;
}

static FILE *create(const char *out_prefix, const char *name) {
  char path[1024];
  int len = snprintf(path, sizeof path, "%s-%s.flicr", out_prefix, name);
  if (len < 0 || (size_t)len >= sizeof path) fail(out_prefix, "too long");
  return open_or_fail(path, "wb");
}

static void write_frame(FILE *file, const uint8_t *frame, const flicr_encoded *encoded) {
  if (fwrite(frame, 1, encoded->len, file) != encoded->len) fail("frame", "cannot be written");
  printf("%6zu bytes, %u of %u cells kept, %u without a return\n", encoded->len, (unsigned)encoded->tally.kept,
         (unsigned)encoded->tally.points, (unsigned)encoded->tally.no_return);
}

/* The next payload's length; 0 behind the last. */
static size_t read_packet(FILE *file, uint8_t *packet) {
  uint8_t head[2];
  if (fread(head, 1, sizeof head, file) != sizeof head) return 0;
  size_t len = (size_t)head[0] | (size_t)head[1] << 8;
  if (len > PACKET_MAX || fread(packet, 1, len, file) != len) fail("packets", "torn or too long");
  return len;
}

static void encode_packets(FILE *packets, FILE *frames) {
  flicr_grid_config config;
  flicr_grid_encoder *encoder;
  flicr_turn turn;
  flicr_packet_stats stats;
  flicr_status status;
  uint8_t packet[PACKET_MAX];
  size_t len;
  check("configuration", flicr_grid_config_init(FLICR_SENSOR_VLP16, COLUMNS, &config));
  check("encoder", flicr_grid_encoder_init_rle(packet_encoder, sizeof packet_encoder, &config, &encoder));
  while ((len = read_packet(packets, packet)) > 0) {
    status = flicr_push_packet(encoder, packet, len, packet_frame, sizeof packet_frame, &turn);
    if (status == FLICR_STATUS_OK)
      write_frame(frames, packet_frame, &turn.encoded);
    else if (status != FLICR_STATUS_TURN_OPEN)
      fprintf(stderr, "%s\n", flicr_status_text(status)); /* the stream goes on */
  }
  status = flicr_finish_packets(encoder, packet_frame, sizeof packet_frame, &turn);
  if (status == FLICR_STATUS_OK) write_frame(frames, packet_frame, &turn.encoded);
  check("counts", flicr_get_packet_stats(encoder, &stats));
  printf("%u packets used, %u refused, %u turns\n", (unsigned)stats.used, (unsigned)stats.refused, (unsigned)stats.turns);
}

/* Firing by firing, as a driver would have them. */
static void encode_returns(FILE *frames) {
  flicr_grid_config config;
  flicr_grid_encoder *encoder;
  flicr_encoded encoded;
  flicr_stamp stamp = {1000000000u, 7};
  flicr_return firing[ROWS];
  check("configuration", flicr_grid_config_init(FLICR_SENSOR_HDL64E, TICKS, &config));
  config.level_bits = 8;
  config.step_m = 0.314f;
  config.table = 0; /* flicr's decoder knows this sensor */
  check("encoder", flicr_grid_encoder_init_deflate_small(return_encoder, sizeof return_encoder, &config, &encoder));
  for (uint32_t tick = 0; tick < TICKS; tick += 2) {
    for (uint32_t row = 0; row < ROWS; row++) {
      firing[row].tick = tick;
      firing[row].row = row;
      firing[row].count = (tick / 2 + row) % 5 ? 2000 + (tick * 7 + row * 131) % 30000 : 0;
    }
    check("returns", flicr_insert_returns(encoder, firing, ROWS, sizeof firing[0]));
  }
  check("frame", flicr_finish_returns(encoder, stamp, return_frame, sizeof return_frame, &encoded));
  write_frame(frames, return_frame, &encoded);
}

int main(int argc, char **argv) {
  if (argc != 3) fail("usage", "packets OUT_PREFIX PACKETS");
  if (flicr_version() != FLICR_VERSION) fail("flicr", "header and library are of different versions");
  FILE *packets = open_or_fail(argv[2], "rb");
  FILE *frames = create(argv[1], "packets");
  encode_packets(packets, frames);
  fclose(packets);
  if (fclose(frames) != 0) fail("packets", "cannot be written");
  frames = create(argv[1], "returns");
  encode_returns(frames);
  if (fclose(frames) != 0) fail("returns", "cannot be written");
  return 0;
}
