/* flicr: a LiDAR codec for the device that the sensor hangs on. Made by cbindgen from src/capi.rs: do not edit.
 *
 *     static uint64_t memory[FLICR_ENCODER_WORDS(4500, 64, FLICR_CODER_DEFLATE)];
 *     static uint8_t frame[FLICR_WORST_CASE_LEN(4500, 64, FLICR_CODER_DEFLATE)];
 *
 *     flicr_config config;
 *     flicr_encoder *encoder;
 *     flicr_encoded encoded;
 *     flicr_stamp stamp = {timestamp_ns, sequence};
 *     flicr_status status = flicr_config_init(FLICR_PRESET_UNIFORM, 4500, 64, &config);
 *     if (!status) status = flicr_encoder_init_deflate(memory, sizeof memory, &config, &encoder);
 *     if (!status) status = flicr_encode(encoder, points, count, sizeof points[0], stamp, frame, sizeof frame, &encoded);
 *     if (status) puts(flicr_status_text(status));
 *
 * What holds for every function:
 * - It returns a status where anything can go wrong; FLICR_STATUS_OK is 0.
 * - Results go to the last argument, and only on success.
 * - All memory is the caller's. An encoder needs no ending: it ends with its memory. It must not be moved or copied.
 * - Every pointer is null (which gives FLICR_STATUS_NULL_POINTER) or points to memory of the length that is given with
 *   it, or of the type's, for the time of the call; an encoder's memory, for as long as it is used.
 * - Nothing is allocated, locked, printed or kept outside the encoder. Different encoders can be used at the same time,
 *   one encoder by one thread at a time.
 */


#ifndef FLICR_H
#define FLICR_H

#include <stddef.h>
#include <stdint.h>

/** The version of this header, to compare with flicr_version(), the library's. */
#define FLICR_VERSION ((uint32_t)(FLICR_VERSION_MAJOR << 16 | FLICR_VERSION_MINOR << 8 | FLICR_VERSION_PATCH))

/** Bytes of a coder's state. */
#define FLICR_CODER_STATE_LEN(coder) \
  ((size_t)((coder) == FLICR_CODER_DEFLATE         ? FLICR_DEFLATE_STATE_LEN \
            : (coder) == FLICR_CODER_DEFLATE_SMALL ? FLICR_DEFLATE_SMALL_STATE_LEN \
            : (coder) == FLICR_CODER_DEFLATE_DENSE ? FLICR_DEFLATE_DENSE_STATE_LEN \
                                                   : 0))

/**
 * Bytes that an encoder takes; a constant where its arguments are. Nothing is checked: flicr_encoder_size and
 * flicr_encoder_init_... do that.
 */
#define FLICR_ENCODER_SIZE(columns, rows, coder) \
  ((size_t)FLICR_ENCODER_OVERHEAD + FLICR_CODER_STATE_LEN(coder) + (size_t)(columns) * (size_t)(rows))

/** As many bytes or a few more, in uint64_t: an array of these is aligned as an encoder must be. */
#define FLICR_ENCODER_WORDS(columns, rows, coder) ((FLICR_ENCODER_SIZE(columns, rows, coder) + 7) / 8)

/** Output bytes that are enough for every frame; a constant where its arguments are. */
#define FLICR_WORST_CASE_LEN(columns, rows, coder) \
  ((size_t)FLICR_FRAME_OVERHEAD_LEN + FLICR_PAYLOAD_LEN((size_t)(columns) * (size_t)(rows), coder))

/** Of these, the payload's: so many pixels, in blocks that each cost some bytes more. */
#define FLICR_PAYLOAD_LEN(pixels, coder) \
  ((pixels) + FLICR_BLOCK_COST(coder) * (((pixels) + FLICR_BLOCK_LEN(coder) - 1) / FLICR_BLOCK_LEN(coder)))
#define FLICR_BLOCK_COST(coder) \
  ((size_t)((coder) == FLICR_CODER_STORE ? 0 : (coder) == FLICR_CODER_RLE ? 1 : FLICR_DEFLATE_BLOCK_COST))
#define FLICR_BLOCK_LEN(coder) \
  ((size_t)((coder) == FLICR_CODER_DEFLATE         ? FLICR_DEFLATE_BLOCK_LEN \
            : (coder) == FLICR_CODER_DEFLATE_SMALL ? FLICR_DEFLATE_SMALL_BLOCK_LEN \
            : (coder) == FLICR_CODER_DEFLATE_DENSE ? FLICR_DEFLATE_DENSE_BLOCK_LEN \
                                                   : FLICR_RLE_BLOCK_LEN))

/**
 * Major version: changes where programs that use this header must be changed.
 */
#define FLICR_VERSION_MAJOR 0

/**
 * Minor version: changes where something is added (and, while the major version is 0, where something breaks).
 */
#define FLICR_VERSION_MINOR 1

/**
 * Patch version.
 */
#define FLICR_VERSION_PATCH 0

/**
 * An encoder's memory must start at a multiple of this many bytes.
 */
#define FLICR_ENCODER_ALIGN 8

/**
 * Bytes that an encoder takes besides its image and its coder's state.
 */
#define FLICR_ENCODER_OVERHEAD 256

/**
 * Bytes that a frame takes besides its payload.
 */
#define FLICR_FRAME_OVERHEAD_LEN 76

/**
 * Bytes of the state of FLICR_CODER_DEFLATE.
 */
#define FLICR_DEFLATE_STATE_LEN 56556

/**
 * Bytes of the state of FLICR_CODER_DEFLATE_SMALL.
 */
#define FLICR_DEFLATE_SMALL_STATE_LEN 13548

/**
 * Bytes of the state of FLICR_CODER_DEFLATE_DENSE.
 */
#define FLICR_DEFLATE_DENSE_STATE_LEN 204012

/**
 * FLICR_CODER_RLE writes one byte more for each so many pixels that do not repeat.
 */
#define FLICR_RLE_BLOCK_LEN 128

/**
 * FLICR_CODER_DEFLATE writes FLICR_DEFLATE_BLOCK_COST bytes more for each so many pixels that it cannot make smaller.
 */
#define FLICR_DEFLATE_BLOCK_LEN 3071

/**
 * As FLICR_DEFLATE_BLOCK_LEN, for FLICR_CODER_DEFLATE_SMALL.
 */
#define FLICR_DEFLATE_SMALL_BLOCK_LEN 1535

/**
 * As FLICR_DEFLATE_BLOCK_LEN, for FLICR_CODER_DEFLATE_DENSE.
 */
#define FLICR_DEFLATE_DENSE_BLOCK_LEN 3071

/**
 * Bytes that every block costs, with any of the three.
 */
#define FLICR_DEFLATE_BLOCK_COST 5

/**
 * What went wrong. The numbers stay what they are; later versions may add some.
 */
enum flicr_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Nothing.
   */
  FLICR_STATUS_OK = 0,
  /**
   * A pointer is null.
   */
  FLICR_STATUS_NULL_POINTER = 1,
  /**
   * A pointer is not aligned for what it points to; an encoder's memory must be to FLICR_ENCODER_ALIGN.
   */
  FLICR_STATUS_MISALIGNED = 2,
  /**
   * The memory is smaller than FLICR_ENCODER_SIZE.
   */
  FLICR_STATUS_STATE_TOO_SMALL = 3,
  /**
   * The memory holds no encoder: no flicr_encoder_init_... has been called, or something wrote over it.
   */
  FLICR_STATUS_NOT_INITIALIZED = 4,
  /**
   * Points, output and encoder share memory.
   */
  FLICR_STATUS_OVERLAP = 5,
  /**
   * A preset that is not in flicr_preset.
   */
  FLICR_STATUS_PRESET = 6,
  /**
   * Rows and columns must be 1 to 65535 each, with at most 2^30 pixels.
   */
  FLICR_STATUS_SIZE = 7,
  /**
   * Level bits must be 1 to 8.
   */
  FLICR_STATUS_LEVEL_BITS = 8,
  /**
   * The largest range must be 0 (the scale follows each frame) or a positive, finite number of meters.
   */
  FLICR_STATUS_MAX_RANGE = 9,
  /**
   * Elevations must satisfy -pi/2 <= bottom < top <= pi/2.
   */
  FLICR_STATUS_ELEVATION_VIEW = 10,
  /**
   * The azimuths must start at -pi to pi and span more than nothing and at most one turn.
   */
  FLICR_STATUS_AZIMUTH_VIEW = 11,
  /**
   * A policy that is not in flicr_collision.
   */
  FLICR_STATUS_COLLISION = 12,
  /**
   * A policy that is not in flicr_out_of_view.
   */
  FLICR_STATUS_OUT_OF_VIEW = 13,
  /**
   * A placement that is not in flicr_placement.
   */
  FLICR_STATUS_PLACEMENT = 14,
  /**
   * A record must have at least the 12 bytes of x, y, z.
   */
  FLICR_STATUS_STRIDE = 15,
  /**
   * More points than memory can hold, or than a frame can count (2^32 - 1).
   */
  FLICR_STATUS_TOO_MANY_POINTS = 16,
  /**
   * The frame does not fit the output buffer. Nothing in the buffer is a frame.
   */
  FLICR_STATUS_OUTPUT_TOO_SMALL = 17,
  /**
   * The scale follows each frame's farthest point: encode whole scans, or configure a largest range.
   */
  FLICR_STATUS_SCALE_NEEDS_WHOLE_SCAN = 18,
  /**
   * No frame has been started.
   */
  FLICR_STATUS_NOT_STARTED = 19,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum flicr_status flicr_status;
#else
typedef int32_t flicr_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Where a configuration starts from.
 */
enum flicr_preset
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * As the code that made the paper's tables: the last point wins, points above or below go to the edge rows, the
   * scale follows each frame, points come back at the corner of their pixel.
   */
  FLICR_PRESET_PAPER = 0,
  /**
   * The best that evenly spaced rows and columns can do: the nearest point wins and comes back in the middle.
   */
  FLICR_PRESET_UNIFORM = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum flicr_preset flicr_preset;
#else
typedef uint32_t flicr_preset;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What makes the levels small. An encoder gets its coder from the function that makes it, so that a linker leaves out
 * all other coders; these are for sizes.
 */
enum flicr_coder
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Nothing: the levels as they are.
   */
  FLICR_CODER_STORE = 0,
  /**
   * Run lengths: no state, the fewest instructions.
   */
  FLICR_CODER_RLE = 1,
  /**
   * DEFLATE (RFC 1951), which every zlib inflates: about as small as zlib -6 makes it, much sooner.
   */
  FLICR_CODER_DEFLATE = 2,
  /**
   * DEFLATE with a quarter of the memory, and a few percent more bytes.
   */
  FLICR_CODER_DEFLATE_SMALL = 3,
  /**
   * DEFLATE with four times the memory, and a few percent fewer bytes.
   */
  FLICR_CODER_DEFLATE_DENSE = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum flicr_coder flicr_coder;
#else
typedef uint32_t flicr_coder;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Which point a pixel keeps where several fall into it.
 */
enum flicr_collision
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * The nearest.
   */
  FLICR_COLLISION_NEAREST = 0,
  /**
   * The farthest.
   */
  FLICR_COLLISION_FARTHEST = 1,
  /**
   * The first inserted.
   */
  FLICR_COLLISION_FIRST = 2,
  /**
   * The last inserted.
   */
  FLICR_COLLISION_LAST = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum flicr_collision flicr_collision;
#else
typedef uint32_t flicr_collision;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What is done with points above the first row or below the last.
 */
enum flicr_out_of_view
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Dropped and counted.
   */
  FLICR_OUT_OF_VIEW_DROP = 0,
  /**
   * Moved into the first or last row, and counted.
   */
  FLICR_OUT_OF_VIEW_CLAMP = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum flicr_out_of_view flicr_out_of_view;
#else
typedef uint32_t flicr_out_of_view;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Where in its pixel a decoded point is put.
 */
enum flicr_placement
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * In the middle: half the largest error.
   */
  FLICR_PLACEMENT_CENTER = 0,
  /**
   * At the corner of smallest azimuth and largest elevation.
   */
  FLICR_PLACEMENT_CORNER = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum flicr_placement flicr_placement;
#else
typedef uint32_t flicr_placement;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * An encoder, in memory of the caller's: this head, the coder's state, the image. To be ended, it needs nothing but
 * its memory's end.
 */
typedef struct flicr_encoder flicr_encoder;

/**
 * What frames are to be like. Filled by flicr_config_init; then change what you like.
 */
typedef struct flicr_config {
  /**
   * Pixels in a row: azimuths. The paper's are 4500, 4096, 2048, 1024, 512 and 256.
   */
  uint32_t columns;
  /**
   * Pixels in a column: elevations, the highest first. The paper's are 64.
   */
  uint32_t rows;
  /**
   * Bits of a level, 1 to 8.
   */
  uint32_t level_bits;
  /**
   * The largest range that has a level, meters; points beyond are dropped and counted. 0: each frame's farthest
   * point, which takes a pass of its own over the points, and whole scans.
   */
  float max_range_m;
  /**
   * Upper edge of row 0, radians above the horizon.
   */
  float top_rad;
  /**
   * Lower edge of the last row, radians above the horizon (mostly negative).
   */
  float bottom_rad;
  /**
   * Azimuth at which column 0 begins, radians from -pi to pi, counterclockwise from x.
   */
  float start_rad;
  /**
   * Azimuth that the columns span, radians; at most one turn.
   */
  float span_rad;
  /**
   * Which point a pixel keeps where several fall into it.
   */
  flicr_collision collision;
  /**
   * What is done with points above the first row or below the last.
   */
  flicr_out_of_view out_of_view;
  /**
   * Where in its pixel a decoded point is put.
   */
  flicr_placement placement;
} flicr_config;

/**
 * What the receiver is told of a frame besides its points.
 */
typedef struct flicr_stamp {
  /**
   * Time of the frame, nanoseconds, of any epoch.
   */
  uint64_t timestamp_ns;
  /**
   * Number of the frame.
   */
  uint32_t sequence;
} flicr_stamp;

/**
 * Points counted by what became of them. points = kept + no_return + not_finite + too_near + beyond_range +
 * out_of_view + collided.
 */
typedef struct flicr_tally {
  /**
   * Points inserted.
   */
  uint32_t points;
  /**
   * In the frame.
   */
  uint32_t kept;
  /**
   * At the origin: the sensor's way of saying that nothing came back.
   */
  uint32_t no_return;
  /**
   * With a coordinate that is NaN or infinite.
   */
  uint32_t not_finite;
  /**
   * Nearer than half a quantizer step.
   */
  uint32_t too_near;
  /**
   * Beyond the largest range.
   */
  uint32_t beyond_range;
  /**
   * Outside the azimuths, or outside the elevations where those are dropped.
   */
  uint32_t out_of_view;
  /**
   * In a pixel that another point was given.
   */
  uint32_t collided;
  /**
   * Of the kept and collided: moved into the first or last row.
   */
  uint32_t clamped;
} flicr_tally;

/**
 * An encoded frame's length, and what became of the points.
 */
typedef struct flicr_encoded {
  /**
   * Bytes written to the front of the output.
   */
  size_t len;
  /**
   * Most that a kept point's range is off after decoding, meters.
   */
  float range_bound_m;
  /**
   * What became of every point.
   */
  struct flicr_tally tally;
} flicr_encoded;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The version of the library, to compare with FLICR_VERSION, the header's.
 */
uint32_t flicr_version(void);

/**
 * A sentence in English for a status; a sentence for numbers that are none, too. Never null, never to be freed.
 */
const char *flicr_status_text(flicr_status status);

/**
 * What FLICR_ENCODER_SIZE gives: bytes that an encoder takes. 0 where there can be none.
 */
size_t flicr_encoder_size(uint32_t columns, uint32_t rows, flicr_coder coder);

/**
 * What FLICR_WORST_CASE_LEN gives: output bytes that are enough for every frame. 0 where there can be none.
 */
size_t flicr_worst_case_len(uint32_t columns, uint32_t rows, flicr_coder coder);

/**
 * Fills a configuration with a preset's choices, for a sensor that looks all around.
 *
 * The presets' elevations are the HDL-64E's: for another sensor, set top_rad and bottom_rad.
 *
 * FLICR_STATUS_PRESET, FLICR_STATUS_SIZE.
 */
flicr_status flicr_config_init(flicr_preset preset, uint32_t columns, uint32_t rows, struct flicr_config *out_config);

/**
 * Makes an encoder that stores levels as they are, in memory of at least
 * FLICR_ENCODER_SIZE(config->columns, config->rows, FLICR_CODER_STORE) bytes, aligned to FLICR_ENCODER_ALIGN. What the
 * memory held does not matter.
 *
 * FLICR_STATUS_STATE_TOO_SMALL, FLICR_STATUS_MISALIGNED, and any status that names a member of the configuration.
 */
flicr_status flicr_encoder_init_store(void *state,
                                      size_t state_len,
                                      const struct flicr_config *config,
                                      struct flicr_encoder **out_encoder);

/**
 * As flicr_encoder_init_store, for FLICR_CODER_RLE.
 */
flicr_status flicr_encoder_init_rle(void *state,
                                    size_t state_len,
                                    const struct flicr_config *config,
                                    struct flicr_encoder **out_encoder);

/**
 * As flicr_encoder_init_store, for FLICR_CODER_DEFLATE.
 */
flicr_status flicr_encoder_init_deflate(void *state,
                                        size_t state_len,
                                        const struct flicr_config *config,
                                        struct flicr_encoder **out_encoder);

/**
 * As flicr_encoder_init_store, for FLICR_CODER_DEFLATE_SMALL.
 */
flicr_status flicr_encoder_init_deflate_small(void *state,
                                              size_t state_len,
                                              const struct flicr_config *config,
                                              struct flicr_encoder **out_encoder);

/**
 * As flicr_encoder_init_store, for FLICR_CODER_DEFLATE_DENSE.
 */
flicr_status flicr_encoder_init_deflate_dense(void *state,
                                              size_t state_len,
                                              const struct flicr_config *config,
                                              struct flicr_encoder **out_encoder);

/**
 * Encodes a whole scan to the front of `out`: `count` records, `stride_bytes` apart, each starting with x, y, z as
 * float, meters (x forward, y left, z up), at any alignment. Of the last record only these 12 bytes are read. A frame
 * that was started is dropped.
 *
 * FLICR_STATUS_OUTPUT_TOO_SMALL, never with FLICR_WORST_CASE_LEN bytes; FLICR_STATUS_STRIDE,
 * FLICR_STATUS_TOO_MANY_POINTS, FLICR_STATUS_OVERLAP.
 */
flicr_status flicr_encode(struct flicr_encoder *encoder,
                          const void *points,
                          size_t count,
                          size_t stride_bytes,
                          struct flicr_stamp stamp,
                          void *out,
                          size_t out_len,
                          struct flicr_encoded *out_encoded);

/**
 * Begins a frame whose points come piece by piece. A frame that was started before is dropped.
 *
 * FLICR_STATUS_SCALE_NEEDS_WHOLE_SCAN where the configuration has no largest range.
 */
flicr_status flicr_start(struct flicr_encoder *encoder, struct flicr_stamp stamp);

/**
 * Puts points into the frame that was started; as in flicr_encode.
 *
 * FLICR_STATUS_NOT_STARTED, FLICR_STATUS_STRIDE, FLICR_STATUS_TOO_MANY_POINTS, FLICR_STATUS_OVERLAP: none of the
 * points are in the frame then.
 */
flicr_status flicr_insert(struct flicr_encoder *encoder, const void *points, size_t count, size_t stride_bytes);

/**
 * Codes the frame that was started to the front of `out`, and ends it.
 *
 * FLICR_STATUS_NOT_STARTED; FLICR_STATUS_OUTPUT_TOO_SMALL and FLICR_STATUS_OVERLAP: the frame stays as it is then, to
 * be finished elsewhere.
 */
flicr_status flicr_finish(struct flicr_encoder *encoder, void *out, size_t out_len, struct flicr_encoded *out_encoded);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* FLICR_H */
