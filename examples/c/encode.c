/*
 * A scan into flicr frames, from C: 4500 x 64 and 256 x 64 pixels, with every coder that compresses.
 *
 *     tools/staticlib.sh x86_64-unknown-linux-gnu        (prints where the library lies)
 *     cc -std=c99 -Iinclude examples/c/encode.c LIBRARY -o encode
 *     ./encode OUT_PREFIX [SCAN.bin]
 *
 * SCAN.bin is in KITTI's format: x, y, z, intensity as little-endian floats. Without one, a room is made up and
 * written to OUT_PREFIX-scan.bin. Frames are written to OUT_PREFIX-COLUMNS-CODER.flicr; `flicr decode` reads them.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "flicr.h"

#define ROWS 64
#define COLUMNS_MAX 4500
#define MAX_RANGE_M 80.0f
#define PIECE 1000 /* points that a sensor's driver might hand over at once */

typedef struct {
  float x, y, z, intensity;
} point;

typedef struct {
  point *points;
  size_t count;
} scan;

typedef flicr_status init_function(void *, size_t, const flicr_config *, flicr_encoder **);

typedef struct {
  uint32_t columns;
  flicr_coder coder;
  init_function *init;
  const char *name;
} frame_kind;

static void fail(const char *what, const char *why) {
  fprintf(stderr, "%s: %s\n", what, why);
  exit(1);
}

static void check(const char *what, flicr_status status) {
  if (status != FLICR_STATUS_OK) fail(what, flicr_status_text(status));
}

/* The context coders are told how far apart levels are, and in what steps they are to be kept: here all of them. */
static flicr_context lossless(const flicr_config *config) {
  flicr_context context;
  check("context", flicr_context_init(config->max_range_m / 255, 0, &context));
  return context;
}

static flicr_status init_small(void *state, size_t len, const flicr_config *config, flicr_encoder **encoder) {
  flicr_context context = lossless(config);
  return flicr_encoder_init_small(state, len, config, &context, encoder);
}

static flicr_status init_dense(void *state, size_t len, const flicr_config *config, flicr_encoder **encoder) {
  flicr_context context = lossless(config);
  return flicr_encoder_init_dense(state, len, config, &context, encoder);
}

static const frame_kind KINDS[] = {
    {4500, FLICR_CODER_RLE, flicr_encoder_init_rle, "rle"},
    {256, FLICR_CODER_RLE, flicr_encoder_init_rle, "rle"},
    {4500, FLICR_CODER_DEFLATE, flicr_encoder_init_deflate, "deflate"},
    {256, FLICR_CODER_DEFLATE, flicr_encoder_init_deflate, "deflate"},
    {4500, FLICR_CODER_DEFLATE_SMALL, flicr_encoder_init_deflate_small, "deflate-small"},
    {256, FLICR_CODER_DEFLATE_SMALL, flicr_encoder_init_deflate_small, "deflate-small"},
    {4500, FLICR_CODER_DEFLATE_DENSE, flicr_encoder_init_deflate_dense, "deflate-dense"},
    {256, FLICR_CODER_DEFLATE_DENSE, flicr_encoder_init_deflate_dense, "deflate-dense"},
    {4500, FLICR_CODER_SMALL, init_small, "small"},
    {256, FLICR_CODER_SMALL, init_small, "small"},
    {4500, FLICR_CODER_DENSE, init_dense, "dense"},
    {256, FLICR_CODER_DENSE, init_dense, "dense"},
};

/* All memory that flicr needs: sized at compile time, for the coder with the largest state and the one whose frames can
 * get longest. */
static uint64_t encoder_memory[FLICR_ENCODER_WORDS(COLUMNS_MAX, ROWS, FLICR_CODER_DEFLATE_DENSE)];
static uint8_t frame[FLICR_WORST_CASE_LEN(COLUMNS_MAX, ROWS, FLICR_CODER_RLE)];
static uint8_t frame_in_pieces[sizeof frame];

static FILE *open_or_fail(const char *path, const char *mode) {
  FILE *file = fopen(path, mode);
  if (!file) fail(path, "cannot be opened");
  return file;
}

static void write_file(const char *path, const void *bytes, size_t len) {
  FILE *file = open_or_fail(path, "wb");
  size_t written = fwrite(bytes, 1, len, file);
  if (fclose(file) != 0 || written != len) fail(path, "cannot be written");
}

static scan allocate(size_t count) {
  scan result = {malloc(count ? count * sizeof(point) : 1), count};
  if (!result.points) fail("scan", "out of memory");
  return result;
}

static scan read_scan(const char *path) {
  FILE *file = open_or_fail(path, "rb");
  long len = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
  if (len < 0 || (size_t)len % sizeof(point) != 0) fail(path, "is no scan of 16-byte points");
  rewind(file);
  scan result = allocate((size_t)len / sizeof(point));
  if (fread(result.points, sizeof(point), result.count, file) != result.count) fail(path, "cannot be read");
  fclose(file);
  return result;
}

/* The inside of a square room, 40 m wide, as 64 beams see it at 1800 places along its walls. */
static scan make_up_scan(void) {
  enum { BEAMS = 64, PLACES = 450 };
  scan result = allocate((size_t)4 * BEAMS * PLACES);
  point *next = result.points;
  for (int side = 0; side < 4; side++) {
    for (int place = 0; place < PLACES; place++) {
      float along = 40.0f * (float)place / PLACES - 20.0f, away = side < 2 ? 20.0f : -20.0f;
      for (int beam = 0; beam < BEAMS; beam++, next++) {
        next->x = side % 2 ? along : away;
        next->y = side % 2 ? away : along;
        next->z = 0.6f - 0.145f * (float)beam;
        next->intensity = 0.5f;
      }
    }
  }
  return result;
}

static flicr_encoder *make_encoder(const frame_kind *kind) {
  flicr_config config;
  flicr_encoder *encoder;
  check("configuration", flicr_config_init(FLICR_PRESET_UNIFORM, kind->columns, ROWS, &config));
  config.max_range_m = MAX_RANGE_M;
  check("encoder", kind->init(encoder_memory, sizeof encoder_memory, &config, &encoder));
  return encoder;
}

static flicr_encoded encode_at_once(flicr_encoder *encoder, scan cloud, flicr_stamp stamp) {
  flicr_encoded encoded;
  check("scan", flicr_encode(encoder, cloud.points, cloud.count, sizeof(point), stamp, frame, sizeof frame, &encoded));
  return encoded;
}

/* As the points come in: the frame is the same. */
static flicr_encoded encode_in_pieces(flicr_encoder *encoder, scan cloud, flicr_stamp stamp) {
  flicr_encoded encoded;
  check("start", flicr_start(encoder, stamp));
  for (size_t at = 0; at < cloud.count; at += PIECE) {
    size_t count = cloud.count - at < PIECE ? cloud.count - at : PIECE;
    check("points", flicr_insert(encoder, cloud.points + at, count, sizeof(point)));
  }
  check("finish", flicr_finish(encoder, frame_in_pieces, sizeof frame_in_pieces, &encoded));
  return encoded;
}

static void write_frame(const char *out_prefix, const frame_kind *kind, scan cloud, flicr_stamp stamp) {
  flicr_encoder *encoder = make_encoder(kind);
  flicr_encoded encoded = encode_at_once(encoder, cloud, stamp);
  flicr_encoded in_pieces = encode_in_pieces(encoder, cloud, stamp);
  if (in_pieces.len != encoded.len || memcmp(frame, frame_in_pieces, encoded.len) != 0)
    fail(kind->name, "pieces make another frame");

  char path[1024];
  int len = snprintf(path, sizeof path, "%s-%u-%s.flicr", out_prefix, (unsigned)kind->columns, kind->name);
  if (len < 0 || (size_t)len >= sizeof path) fail(out_prefix, "too long");
  write_file(path, frame, encoded.len);
  printf("%4u x %d %-13s %6zu bytes, %6zu of RAM, %u of %u points kept, ranges within %.3f m\n",
         (unsigned)kind->columns, ROWS, kind->name, encoded.len, flicr_encoder_size(kind->columns, ROWS, kind->coder),
         (unsigned)encoded.tally.kept, (unsigned)encoded.tally.points, (double)encoded.range_bound_m);
}

static scan get_scan(const char *out_prefix, const char *path) {
  if (path) return read_scan(path);
  char made_up[1024];
  int len = snprintf(made_up, sizeof made_up, "%s-scan.bin", out_prefix);
  if (len < 0 || (size_t)len >= sizeof made_up) fail(out_prefix, "too long");
  scan result = make_up_scan();
  write_file(made_up, result.points, result.count * sizeof(point));
  return result;
}

int main(int argc, char **argv) {
  if (argc < 2 || argc > 3) fail("usage", "encode OUT_PREFIX [SCAN.bin]");
  if (flicr_version() != FLICR_VERSION) fail("flicr", "header and library are of different versions");
  scan cloud = get_scan(argv[1], argc == 3 ? argv[2] : NULL);
  flicr_stamp stamp = {1000000000u, 7};
  for (size_t i = 0; i < sizeof KINDS / sizeof KINDS[0]; i++) write_frame(argv[1], &KINDS[i], cloud, stamp);
  free(cloud.points);
  return 0;
}
