/* flicr: a LiDAR codec for the device that the sensor hangs on. Made by cbindgen from src/capi: do not edit.
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
 * The context coders take their settings too:
 *
 *     flicr_context context;
 *     if (!status) status = flicr_context_init(config.max_range_m / 255, 0, &context);
 *     if (!status) status = flicr_encoder_init_small(memory, sizeof memory, &config, &context, &encoder);
 *
 * A sensor's packets, one UDP payload at a time, a frame for each turn:
 *
 *     static uint64_t memory[FLICR_GRID_ENCODER_WORDS(1800, 16, 16, FLICR_CODER_RLE)];
 *     static uint8_t frame[FLICR_GRID_WORST_CASE_LEN(1800, 16, 16, FLICR_CODER_RLE)];
 *
 *     flicr_grid_config config;
 *     flicr_grid_encoder *encoder;
 *     flicr_turn turn;
 *     flicr_status status = flicr_grid_config_init(FLICR_SENSOR_VLP16, 1800, &config);
 *     if (!status) status = flicr_grid_encoder_init_rle(memory, sizeof memory, &config, &encoder);
 *     while (!status) {
 *       size_t len = recv(socket, packet, sizeof packet, 0);
 *       flicr_status pushed = flicr_push_packet(encoder, packet, len, frame, sizeof frame, &turn);
 *       if (!pushed) send_frame(frame, turn.encoded.len);
 *     }
 *
 * A driver that has beams, ticks and range counts already hands them to flicr_insert_returns.
 *
 * The same packets as a stream, in datagrams that go out while the sensor turns:
 *
 *     static uint64_t memory[FLICR_STREAM_WORDS(16, FLICR_CODER_SMALL, 0)];
 *     static void send_datagram(void *socket, const uint8_t *datagram, size_t len) { ... }
 *
 *     flicr_stream *stream;
 *     flicr_status status = flicr_grid_config_init(FLICR_SENSOR_VLP16, 1800, &config);
 *     if (!status) status = flicr_context_init(config.step_m, 0.02f, &context);
 *     if (!status) status = flicr_stream_init_small(memory, sizeof memory, &config, &context, 0, &stream);
 *     while (!status) {
 *       size_t len = recv(socket, packet, sizeof packet, 0);
 *       flicr_stream_push_packet(stream, packet, len, send_datagram, &socket);
 *     }
 *
 * Intensities and times go along where a driver has them: flicr_insert_lit_returns (flicr_insert_lit for points), then
 * flicr_finish_returns_with (flicr_finish_with), with a flicr_planes that says where they are.
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
            : (coder) == FLICR_CODER_SMALL         ? FLICR_SMALL_STATE_LEN \
            : (coder) == FLICR_CODER_DENSE         ? FLICR_DENSE_STATE_LEN \
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

/** As FLICR_WORST_CASE_LEN, for frames of so many strips. */
#define FLICR_WORST_CASE_LEN_IN_STRIPS(columns, rows, coder, strips) \
  ((size_t)FLICR_FRAME_OVERHEAD_LEN + (size_t)FLICR_STRIP_OVERHEAD_LEN * ((size_t)(strips) - 1) \
   + FLICR_WIDER_STRIPS(columns, strips) \
       * FLICR_PAYLOAD_LEN((FLICR_STRIP_COLUMNS(columns, strips) + 1) * (size_t)(rows), coder) \
   + ((size_t)(strips) - FLICR_WIDER_STRIPS(columns, strips)) \
       * FLICR_PAYLOAD_LEN(FLICR_STRIP_COLUMNS(columns, strips) * (size_t)(rows), coder) \
   + FLICR_GATHERED_LEN(columns, rows, coder, strips, 1))
/** Output bytes that are enough for intensities and times, besides those for a frame without them. */
#define FLICR_PLANES_WORST_CASE_LEN(columns, rows, strips) \
  ((size_t)FLICR_INTENSITY_OVERHEAD_LEN + (size_t)FLICR_INTENSITY_STRIP_LEN * (size_t)(strips) \
   + (size_t)(columns) * (size_t)(rows) + (size_t)FLICR_TIMES_OVERHEAD_LEN \
   + (size_t)FLICR_TIMES_STRIP_LEN * (size_t)(strips) + (size_t)FLICR_TIMES_COLUMN_LEN * (size_t)(columns))

#define FLICR_STRIP_COLUMNS(columns, strips) ((size_t)(columns) / (size_t)(strips))
#define FLICR_WIDER_STRIPS(columns, strips) ((size_t)(columns) % (size_t)(strips))
#define FLICR_GATHERED_LEN(columns, rows, coder, strips, level_len) \
  ((coder) == FLICR_CODER_STORE || (coder) == FLICR_CODER_SMALL || (coder) == FLICR_CODER_DENSE || (strips) == 1 \
     ? 0 \
     : ((size_t)(columns) + (size_t)(strips) - 1) / (size_t)(strips) * (size_t)(rows) * (level_len) + (level_len) - 1)

/** Of these, the payload's: so many pixels, in blocks that each cost some bytes more. */
#define FLICR_PAYLOAD_LEN(pixels, coder) \
  ((pixels) + FLICR_BLOCK_COST(coder) * (((pixels) + FLICR_BLOCK_LEN(coder) - 1) / FLICR_BLOCK_LEN(coder)))
#define FLICR_BLOCK_COST(coder) \
  ((size_t)((coder) == FLICR_CODER_STORE   ? 0 \
            : (coder) == FLICR_CODER_RLE   ? 1 \
            : (coder) == FLICR_CODER_SMALL ? FLICR_CONTEXT_BLOCK_COST \
            : (coder) == FLICR_CODER_DENSE ? FLICR_CONTEXT_BLOCK_COST \
                                           : FLICR_DEFLATE_BLOCK_COST))
#define FLICR_BLOCK_LEN(coder) \
  ((size_t)((coder) == FLICR_CODER_DEFLATE         ? FLICR_DEFLATE_BLOCK_LEN \
            : (coder) == FLICR_CODER_DEFLATE_SMALL ? FLICR_DEFLATE_SMALL_BLOCK_LEN \
            : (coder) == FLICR_CODER_DEFLATE_DENSE ? FLICR_DEFLATE_DENSE_BLOCK_LEN \
            : (coder) == FLICR_CODER_SMALL         ? FLICR_CONTEXT_BLOCK_LEN \
            : (coder) == FLICR_CODER_DENSE         ? FLICR_CONTEXT_BLOCK_LEN \
                                                   : FLICR_RLE_BLOCK_LEN))

/** Bytes of a pixel on a grid. */
#define FLICR_LEVEL_LEN(level_bits) ((size_t)((level_bits) > 8 ? 2 : 1))

/** As FLICR_ENCODER_SIZE, for an encoder on a grid. */
#define FLICR_GRID_ENCODER_SIZE(columns, beams, level_bits, coder) \
  ((size_t)FLICR_GRID_ENCODER_OVERHEAD + FLICR_CODER_STATE_LEN(coder) + (size_t)FLICR_BEAM_LEN * (size_t)(beams) \
   + FLICR_LEVEL_LEN(level_bits) * (size_t)(columns) * (size_t)(beams))

/** As FLICR_ENCODER_WORDS, for an encoder on a grid. */
#define FLICR_GRID_ENCODER_WORDS(columns, beams, level_bits, coder) \
  ((FLICR_GRID_ENCODER_SIZE(columns, beams, level_bits, coder) + 7) / 8)

/** Output bytes that are enough for every frame on a grid, with its beams; a constant where its arguments are. */
#define FLICR_GRID_WORST_CASE_LEN(columns, beams, level_bits, coder) \
  ((size_t)FLICR_GRID_FRAME_OVERHEAD_LEN + (size_t)FLICR_BEAM_LEN * (size_t)(beams) \
   + FLICR_GRID_PAYLOAD_LEN((size_t)(columns) * (size_t)(beams) * FLICR_LEVEL_LEN(level_bits), level_bits, coder))

/** As FLICR_GRID_WORST_CASE_LEN, for frames of so many strips. */
#define FLICR_GRID_WORST_CASE_LEN_IN_STRIPS(columns, beams, level_bits, coder, strips) \
  ((size_t)FLICR_GRID_FRAME_OVERHEAD_LEN + (size_t)FLICR_BEAM_LEN * (size_t)(beams) \
   + (size_t)FLICR_STRIP_OVERHEAD_LEN * ((size_t)(strips) - 1) \
   + FLICR_WIDER_STRIPS(columns, strips) \
       * FLICR_GRID_STRIP_LEN(FLICR_STRIP_COLUMNS(columns, strips) + 1, beams, level_bits, coder) \
   + ((size_t)(strips) - FLICR_WIDER_STRIPS(columns, strips)) \
       * FLICR_GRID_STRIP_LEN(FLICR_STRIP_COLUMNS(columns, strips), beams, level_bits, coder) \
   + FLICR_GATHERED_LEN(columns, beams, coder, strips, FLICR_LEVEL_LEN(level_bits)))
#define FLICR_GRID_STRIP_LEN(columns, beams, level_bits, coder) \
  FLICR_GRID_PAYLOAD_LEN((columns) * (size_t)(beams) * FLICR_LEVEL_LEN(level_bits), level_bits, coder)

/** Of these, the payload's: so many bytes of levels, in blocks that each cost some bytes more. */
#define FLICR_GRID_PAYLOAD_LEN(bytes, level_bits, coder) \
  ((bytes) + FLICR_BLOCK_COST(coder) * (((bytes) + FLICR_GRID_BLOCK_LEN(level_bits, coder) - 1) \
                                        / FLICR_GRID_BLOCK_LEN(level_bits, coder)))
#define FLICR_GRID_BLOCK_LEN(level_bits, coder) \
  (FLICR_BLOCK_LEN(coder) * ((coder) == FLICR_CODER_RLE ? FLICR_LEVEL_LEN(level_bits) : 1))

/**
 * Bytes that a stream takes, its datagram included; a constant where its arguments are. `coder` is FLICR_CODER_SMALL or
 * FLICR_CODER_DENSE, `aligned` 1 where columns are aligned, 0 as fired.
 */
#define FLICR_STREAM_SIZE(beams, coder, aligned) \
  ((size_t)FLICR_STREAM_OVERHEAD + (size_t)FLICR_BEAM_LEN * (size_t)(beams) \
   + ((coder) == FLICR_CODER_SMALL ? FLICR_STREAM_SMALL_STATE_LEN : FLICR_STREAM_DENSE_STATE_LEN) \
   + ((aligned) ? FLICR_STREAM_ALIGNED_LEN : 0))

/** As many bytes or a few more, in uint64_t. */
#define FLICR_STREAM_WORDS(beams, coder, aligned) ((FLICR_STREAM_SIZE(beams, coder, aligned) + 7) / 8)

/** Bytes that a datagram of `len` bytes takes in a byte stream, at most. */
#define FLICR_FRAMED_LEN(len) ((size_t)(len) + (size_t)(len) / 254 + 3)

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
 * Most rows of an image that FLICR_CODER_SMALL and FLICR_CODER_DENSE take.
 */
#define FLICR_CONTEXT_ROWS_MAX 128

/**
 * Bytes of the state of FLICR_CODER_SMALL.
 */
#define FLICR_SMALL_STATE_LEN 2688

/**
 * Bytes of the state of FLICR_CODER_DENSE.
 */
#define FLICR_DENSE_STATE_LEN 5376

/**
 * Bytes that a payload of FLICR_CODER_SMALL or FLICR_CODER_DENSE takes at most besides its levels, once for each
 * FLICR_CONTEXT_BLOCK_LEN bytes of these.
 */
#define FLICR_CONTEXT_BLOCK_COST 6

/**
 * See FLICR_CONTEXT_BLOCK_COST.
 */
#define FLICR_CONTEXT_BLOCK_LEN 1073741824

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
 * Of these, those that each strip takes.
 */
#define FLICR_STRIP_OVERHEAD_LEN 8

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
 * Bytes that a grid encoder takes besides its beams, its coder's state and its image.
 */
#define FLICR_GRID_ENCODER_OVERHEAD 768

/**
 * Bytes that a frame on a grid takes besides its payload, and its beams where it carries them.
 */
#define FLICR_GRID_FRAME_OVERHEAD_LEN 84

/**
 * Bytes of a beam, in an encoder and in a frame.
 */
#define FLICR_BEAM_LEN 20

/**
 * Most rows that intensities can have.
 */
#define FLICR_INTENSITY_ROWS_MAX 128

/**
 * Bytes of memory that intensities are coded with.
 */
#define FLICR_INTENSITY_STATE_LEN 33536

/**
 * Bytes by which intensities make a frame longer, besides FLICR_INTENSITY_STRIP_LEN a strip and one a pixel, at most.
 */
#define FLICR_INTENSITY_OVERHEAD_LEN 16

/**
 * Bytes of these that each strip takes.
 */
#define FLICR_INTENSITY_STRIP_LEN 6

/**
 * Bytes by which times make a frame longer, besides FLICR_TIMES_STRIP_LEN a strip and FLICR_TIMES_COLUMN_LEN a column, at
 * most.
 */
#define FLICR_TIMES_OVERHEAD_LEN 12

/**
 * Bytes of these that each strip takes.
 */
#define FLICR_TIMES_STRIP_LEN 21

/**
 * Bytes of these that each column takes.
 */
#define FLICR_TIMES_COLUMN_LEN 56

/**
 * Most beams of a sensor.
 */
#define FLICR_BEAMS_MAX 128

/**
 * Bytes of a datagram at most.
 */
#define FLICR_DATAGRAM_LEN 1400

/**
 * Bytes that a stream takes besides its beams and its coder's state.
 */
#define FLICR_STREAM_OVERHEAD 384

/**
 * Bytes of the state of a stream with FLICR_CODER_SMALL, the datagram included.
 */
#define FLICR_STREAM_SMALL_STATE_LEN 5120

/**
 * Bytes of the state of a stream with FLICR_CODER_DENSE, the datagram included.
 */
#define FLICR_STREAM_DENSE_STATE_LEN 7936

/**
 * Bytes that aligned columns take more: enough for an HDL-64E, and for sensors whose beams look less far apart.
 */
#define FLICR_STREAM_ALIGNED_LEN 9728

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
   * Points, output, encoder and the place of the result share memory.
   */
  FLICR_STATUS_OVERLAP = 5,
  /**
   * A preset that is not in flicr_preset.
   */
  FLICR_STATUS_PRESET = 6,
  /**
   * Rows and columns must be 1 to 65535 each, with at most 2^30 pixels; a coder may take fewer rows.
   */
  FLICR_STATUS_SIZE = 7,
  /**
   * Level bits must be 1 to 8, on a grid 1 to 16.
   */
  FLICR_STATUS_LEVEL_BITS = 8,
  /**
   * The largest range must be 0 (the scale follows each frame) or a positive, finite number of meters; on a grid the
   * step must be such a number.
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
  /**
   * A sensor that is not in flicr_sensor, or lacks what is asked of it: beams in that number, or packets.
   */
  FLICR_STATUS_SENSOR = 20,
  /**
   * A policy that is not in flicr_return_policy.
   */
  FLICR_STATUS_RETURN_POLICY = 21,
  /**
   * The beams' slopes must fall from row to row, and their numbers be such as a sensor can have.
   */
  FLICR_STATUS_BEAM = 22,
  /**
   * A turn has 1 to 2^20 ticks.
   */
  FLICR_STATUS_TICKS = 23,
  /**
   * A range unit is more than 0 and at most a meter.
   */
  FLICR_STATUS_RANGE_UNIT = 24,
  /**
   * No error: the packet has been taken, and the turn goes on. Nothing has been encoded.
   */
  FLICR_STATUS_TURN_OPEN = 25,
  /**
   * The packet is not one of the sensor's, is damaged, late or doubled. Nothing of it is used.
   */
  FLICR_STATUS_PACKET_REFUSED = 26,
  /**
   * A step must be 1 to 65535 levels, the noise 0 to 255, the predictor in flicr_predictor.
   */
  FLICR_STATUS_CONTEXT = 27,
  /**
   * A frame is cut into 1 strip to as many as it has columns.
   */
  FLICR_STATUS_STRIPS = 28,
  /**
   * Aligned columns take more room than there is, or a turn's columns are not 1 to 8192.
   */
  FLICR_STATUS_DELAY = 29,
  /**
   * A companding that is not in flicr_companding.
   */
  FLICR_STATUS_COMPANDING = 30,
  /**
   * In a stream a level must be 1 to 255 whole range units.
   */
  FLICR_STATUS_STEP = 31,
  /**
   * An intensity's numbers for 1 must be positive and finite, its step 1 to 255, a time's unit not 0.
   */
  FLICR_STATUS_PLANE = 32,
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
  /**
   * The context coder made for range images, its small tier: two thirds of DEFLATE's bytes and fewer, lossless or in
   * steps.
   */
  FLICR_CODER_SMALL = 5,
  /**
   * The same, its dense tier: the fewest bytes.
   */
  FLICR_CODER_DENSE = 6,
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
 * How levels are spread over ranges.
 */
enum flicr_companding
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Evenly.
   */
  FLICR_COMPANDING_NONE = 0,
  /**
   * By the square root, for up to 8 bits: finer near, coarser far, with less error on the whole. A step is the range of
   * level 1 then.
   */
  FLICR_COMPANDING_SQUARE_ROOT = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum flicr_companding flicr_companding;
#else
typedef uint32_t flicr_companding;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Sensors whose grids are known, and but for the first two and the last their packets.
 */
enum flicr_sensor
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Any that sends no packets known here: its grid is all in flicr_grid_config.
   */
  FLICR_SENSOR_CUSTOM = 0,
  /**
   * Velodyne HDL-64E, KITTI's unit: returns only.
   */
  FLICR_SENSOR_HDL64E = 1,
  /**
   * Velodyne VLP-16 and Puck LITE.
   */
  FLICR_SENSOR_VLP16 = 2,
  /**
   * Velodyne Puck Hi-Res.
   */
  FLICR_SENSOR_PUCK_HI_RES = 3,
  /**
   * Velodyne VLP-32C.
   */
  FLICR_SENSOR_VLP32C = 4,
  /**
   * Velodyne HDL-32E.
   */
  FLICR_SENSOR_HDL32E = 5,
  /**
   * Velodyne VLS-128.
   */
  FLICR_SENSOR_VLS128 = 6,
  /**
   * Hesai Pandar40P.
   */
  FLICR_SENSOR_PANDAR40P = 7,
  /**
   * Hesai Pandar64.
   */
  FLICR_SENSOR_PANDAR64 = 8,
  /**
   * Hesai PandarXT-32.
   */
  FLICR_SENSOR_PANDAR_XT32 = 9,
  /**
   * As FLICR_SENSOR_HDL64E, where each laser's own angle is in its beam and all of a firing share its tick: for streams.
   */
  FLICR_SENSOR_HDL64E_FIRINGS = 10,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum flicr_sensor flicr_sensor;
#else
typedef uint32_t flicr_sensor;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Which of two returns in a packet is meant.
 */
enum flicr_return_policy
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * The stronger.
   */
  FLICR_RETURN_POLICY_STRONGEST = 0,
  /**
   * The farther.
   */
  FLICR_RETURN_POLICY_LAST = 1,
  /**
   * The one that FLICR_RETURN_POLICY_STRONGEST leaves; none where the sensor repeats the only one it has. For both, push
   * each packet into an encoder of either.
   */
  FLICR_RETURN_POLICY_OTHER = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum flicr_return_policy flicr_return_policy;
#else
typedef uint32_t flicr_return_policy;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What FLICR_CODER_SMALL and FLICR_CODER_DENSE predict a level from.
 */
enum flicr_predictor
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * The same beam's pixel before.
   */
  FLICR_PREDICTOR_WEST = 0,
  /**
   * The median of what three neighbors say: sometimes a few percent less where columns are few.
   */
  FLICR_PREDICTOR_MEDIAN_EDGE = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum flicr_predictor flicr_predictor;
#else
typedef uint32_t flicr_predictor;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * An encoder, in memory of the caller's: this head, the coder's state, the image. To be ended, it needs nothing but
 * its memory's end.
 */
typedef struct flicr_encoder flicr_encoder;

/**
 * An encoder on a grid, in memory of the caller's: this head, the coder's state, the beams, the image.
 */
typedef struct flicr_grid_encoder flicr_grid_encoder;

/**
 * A stream, in memory of the caller's: this head, the coder's state, the beams. To be ended, it needs nothing but its
 * memory's end.
 */
typedef struct flicr_stream flicr_stream;

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
  /**
   * How levels are spread over ranges.
   */
  flicr_companding companding;
  /**
   * Strips that a frame is cut into, 1 to `columns`: runs of columns that decode alone. 1 unless set; with more, see
   * FLICR_WORST_CASE_LEN_IN_STRIPS.
   */
  uint32_t strips;
} flicr_config;

/**
 * How FLICR_CODER_SMALL and FLICR_CODER_DENSE go about an image. Filled by flicr_context_init; then change what you
 * like.
 */
typedef struct flicr_context {
  /**
   * Levels a step, 1 to 65535. 1: nothing is lost.
   */
  uint32_t step_levels;
  /**
   * 1: what is within 0.6 steps of its prediction takes its value, which saves a tenth of the bytes. 0: no point is
   * more than half a step off.
   */
  uint32_t dead_zone;
  /**
   * Levels that are a beam's noise, not a surface, 0 to 255: about 4 cm, 0 where levels are as coarse as that. No
   * level is lost by a wrong one, but bytes are.
   */
  uint32_t noise_levels;
  /**
   * What a level is predicted from.
   */
  flicr_predictor predictor;
} flicr_context;

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

/**
 * What a frame is to carry besides ranges: intensities, times, or both. All of it is the caller's memory, used during the
 * calls that it is given to.
 */
typedef struct flicr_planes {
  /**
   * A number for each pixel, columns x rows of them, row by row: flicr_insert_lit and flicr_insert_lit_returns put them
   * there, flicr_finish_with and flicr_finish_returns_with take them from there. Null: no intensities.
   */
  uint8_t *intensities;
  /**
   * FLICR_INTENSITY_STATE_LEN bytes at an even address, whatever they hold; not looked at without intensities.
   */
  void *intensity_state;
  /**
   * Numbers for an intensity of 1: 1 for a sensor's own numbers, 100 for hundredths. Positive and finite.
   */
  float intensity_per_unit;
  /**
   * Distance of the numbers that are kept, 1 to 255: 1 keeps them as they are, 16 about 4 bits of them.
   */
  uint32_t intensity_step;
  /**
   * A time for each column, nanoseconds of the stamp's epoch; 0 where it is not known. Null: no times.
   */
  const uint64_t *times_ns;
  /**
   * Times are kept in whole units of this, not 0.
   */
  uint32_t time_unit_ns;
} flicr_planes;

/**
 * One laser of a spinning sensor. docs/FORMAT.md says where its returns lie.
 */
typedef struct flicr_beam {
  /**
   * Tangent of the elevation.
   */
  float slope;
  /**
   * Height over the sensor's origin at which the beam, prolonged, crosses the spin axis, meters.
   */
  float z_offset_m;
  /**
   * Sideways distance of the beam from the spin axis, meters; positive to the right.
   */
  float h_offset_m;
  /**
   * What the beam adds to the encoder's azimuth, radians counterclockwise seen from above.
   */
  float azimuth_phase_rad;
  /**
   * Range of count 0, meters.
   */
  float range_phase_m;
} flicr_beam;

/**
 * What frames on a sensor's own grid are to be like. Filled by flicr_grid_config_init; then change what you like.
 */
typedef struct flicr_grid_config {
  /**
   * Whose packets come.
   */
  flicr_sensor sensor;
  /**
   * Turns a minute, at most 6000: the known sensors' beams fire one after another while the sensor turns. 0: all at
   * once.
   */
  uint32_t turns_per_minute;
  /**
   * The beams, highest first; copied by flicr_grid_encoder_init_... Null: those of the sensor.
   */
  const struct flicr_beam *beams;
  /**
   * Beams, and rows of the image: 1 to FLICR_BEAMS_MAX.
   */
  uint32_t beam_count;
  /**
   * Encoder ticks a turn.
   */
  uint32_t ticks;
  /**
   * 1 where ticks grow clockwise, seen from above; 0 where not.
   */
  uint32_t clockwise;
  /**
   * Azimuth of tick 0, radians from -pi to pi, counterclockwise from x.
   */
  float zero_rad;
  /**
   * One range count, meters.
   */
  float range_unit_m;
  /**
   * 1 where the distance that a range gives along the ground counts from the spin axis, 0 where from the place where
   * the beam passes it.
   */
  uint32_t range_from_axis;
  /**
   * Columns, spread evenly over the turn from tick 0 on.
   */
  uint32_t columns;
  /**
   * Bits of a level: 1 to 8 take a byte a pixel, 9 to 16 take two.
   */
  uint32_t level_bits;
  /**
   * Distance of the levels, meters. The range unit: nothing is lost.
   */
  float step_m;
  /**
   * Which return a pixel keeps where several fall into it.
   */
  flicr_collision collision;
  /**
   * Which of two returns in a packet is meant.
   */
  flicr_return_policy returns;
  /**
   * 1 where each frame carries the beams (20 bytes each), for receivers that do not know them; 0 where not.
   */
  uint32_t table;
  /**
   * How levels are spread over ranges.
   */
  flicr_companding companding;
  /**
   * Strips that a frame is cut into, 1 to `columns`: runs of columns that decode alone. 1 unless set; with more, see
   * FLICR_GRID_WORST_CASE_LEN_IN_STRIPS.
   */
  uint32_t strips;
} flicr_grid_config;

/**
 * A turn that a packet has ended.
 */
typedef struct flicr_turn {
  /**
   * The frame's length, and what became of the returns. Its number is the turn's, its time that of the first column
   * in the sensor's clock, nanoseconds.
   */
  struct flicr_encoded encoded;
  /**
   * Number of the turn since the stream began, lost ones counted.
   */
  uint32_t number;
  /**
   * Firings in the turn, missing ones counted.
   */
  uint32_t columns;
  /**
   * Firings that are missing: lost, not measured, or from before the stream began.
   */
  uint32_t missing;
} flicr_turn;

/**
 * What became of an encoder's packets.
 */
typedef struct flicr_packet_stats {
  /**
   * Packets used.
   */
  uint32_t used;
  /**
   * Packets refused.
   */
  uint32_t refused;
  /**
   * Firings in the packets used.
   */
  uint32_t columns;
  /**
   * Firings that packets lost or refused should have held.
   */
  uint32_t lost_columns;
  /**
   * Turns that ended.
   */
  uint32_t turns;
  /**
   * Turns of which nothing was received.
   */
  uint32_t lost_turns;
} flicr_packet_stats;

/**
 * Where datagrams go: called with each as soon as it is full, with the `context` that was given along with it. The
 * datagram lives as long as the call, which must not use the stream that it comes from.
 */
typedef void (*flicr_send)(void *context, const uint8_t *datagram, size_t datagram_len);

/**
 * A firing of all beams.
 */
typedef struct flicr_column {
  /**
   * When it was, in the sensor's clock, nanoseconds.
   */
  uint64_t time_ns;
  /**
   * Its number in the turn, 0 to 8191. Columns of a turn come in ascending order; one that is left out was lost.
   */
  uint32_t index;
  /**
   * The encoder's tick.
   */
  uint32_t tick;
} flicr_column;

/**
 * What has become of a stream's firings.
 */
typedef struct flicr_stream_tally {
  /**
   * Returns that came in and have a level; those of columns that are not kept are among them.
   */
  uint64_t returns;
  /**
   * Returns beyond the largest level; not kept.
   */
  uint64_t beyond_range;
  /**
   * Bytes of the datagrams.
   */
  uint64_t bytes;
  /**
   * Datagrams that went out.
   */
  uint32_t datagrams;
  /**
   * Firings that came in.
   */
  uint32_t firings;
  /**
   * Columns that are in datagrams, or will be in the next.
   */
  uint32_t columns;
  /**
   * Columns that a stride passed over.
   */
  uint32_t thinned;
  /**
   * Columns that flicr_stream_cut cut off.
   */
  uint32_t cut;
  /**
   * Columns that did not fit a datagram alone.
   */
  uint32_t unfit;
} flicr_stream_tally;

/**
 * One return, in its sensor's own integers.
 */
typedef struct flicr_return {
  /**
   * The encoder's tick.
   */
  uint32_t tick;
  /**
   * Range in range units; 0 is no return.
   */
  uint32_t count;
  /**
   * The beam; row 0 is the highest.
   */
  uint32_t row;
} flicr_return;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The version of the library, to compare with FLICR_VERSION, the header's.
 */
uint32_t flicr_version(void);

/**
 * Fills a configuration with a preset's choices, for a sensor that looks all around.
 *
 * The presets' elevations are the HDL-64E's: for another sensor, set top_rad and bottom_rad.
 *
 * FLICR_STATUS_PRESET, FLICR_STATUS_SIZE.
 */
flicr_status flicr_config_init(flicr_preset preset, uint32_t columns, uint32_t rows, struct flicr_config *out_config);

/**
 * Fills a context coder's settings, for levels `level_m` meters apart that are to be kept in steps of `step_m` meters:
 * rounded to levels, one at least; 0 loses nothing.
 *
 * With 8 bits, levels are max_range_m / 255 apart; on a grid, the configuration's step_m.
 *
 * FLICR_STATUS_CONTEXT where level_m is not positive and finite, step_m is negative, or is more than 65535 levels.
 */
flicr_status flicr_context_init(float level_m, float step_m, struct flicr_context *out_context);

/**
 * What FLICR_ENCODER_SIZE gives: bytes that an encoder takes. 0 where there can be none.
 */
size_t flicr_encoder_size(uint32_t columns, uint32_t rows, flicr_coder coder);

/**
 * What FLICR_WORST_CASE_LEN gives: output bytes that are enough for every frame. 0 where there can be none.
 */
size_t flicr_worst_case_len(uint32_t columns, uint32_t rows, flicr_coder coder);

/**
 * What FLICR_WORST_CASE_LEN_IN_STRIPS gives: output bytes that are enough for every frame of so many strips. 0 where
 * there can be none.
 */
size_t flicr_worst_case_len_in_strips(uint32_t columns, uint32_t rows, flicr_coder coder, uint32_t strips);

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
 * As flicr_encoder_init_store, for FLICR_CODER_SMALL with these settings.
 *
 * FLICR_STATUS_CONTEXT; FLICR_STATUS_SIZE with more than FLICR_CONTEXT_ROWS_MAX rows, too.
 */
flicr_status flicr_encoder_init_small(void *state,
                                      size_t state_len,
                                      const struct flicr_config *config,
                                      const struct flicr_context *context,
                                      struct flicr_encoder **out_encoder);

/**
 * As flicr_encoder_init_small, for FLICR_CODER_DENSE.
 */
flicr_status flicr_encoder_init_dense(void *state,
                                      size_t state_len,
                                      const struct flicr_config *config,
                                      const struct flicr_context *context,
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

/**
 * As flicr_insert, with an intensity for each point: `numbers` are `count` of them, and that of a point that a pixel keeps
 * goes into planes->intensities.
 */
flicr_status flicr_insert_lit(struct flicr_encoder *encoder,
                              const void *points,
                              size_t count,
                              size_t stride_bytes,
                              const uint8_t *numbers,
                              const struct flicr_planes *planes);

/**
 * As flicr_finish, with planes besides the ranges.
 *
 * FLICR_STATUS_PLANE; FLICR_STATUS_SIZE where there are intensities of more than FLICR_INTENSITY_ROWS_MAX rows;
 * FLICR_STATUS_OUTPUT_TOO_SMALL, never with FLICR_PLANES_WORST_CASE_LEN bytes more than the frame takes without.
 */
flicr_status flicr_finish_with(struct flicr_encoder *encoder,
                               const struct flicr_planes *planes,
                               void *out,
                               size_t out_len,
                               struct flicr_encoded *out_encoded);

/**
 * What FLICR_GRID_ENCODER_SIZE gives: bytes that an encoder takes. 0 where there can be none.
 */
size_t flicr_grid_encoder_size(uint32_t columns, uint32_t beams, uint32_t level_bits, flicr_coder coder);

/**
 * What FLICR_GRID_WORST_CASE_LEN gives: output bytes that are enough for every frame. 0 where there can be none.
 */
size_t flicr_grid_worst_case_len(uint32_t columns, uint32_t beams, uint32_t level_bits, flicr_coder coder);

/**
 * What FLICR_GRID_WORST_CASE_LEN_IN_STRIPS gives: output bytes that are enough for every frame of so many strips. 0 where
 * there can be none.
 */
size_t flicr_grid_worst_case_len_in_strips(uint32_t columns,
                                           uint32_t beams,
                                           uint32_t level_bits,
                                           flicr_coder coder,
                                           uint32_t strips);

/**
 * Makes an encoder that stores levels as they are, in memory of at least FLICR_GRID_ENCODER_SIZE(config->columns,
 * config->beam_count, config->level_bits, FLICR_CODER_STORE) bytes, aligned to FLICR_ENCODER_ALIGN.
 *
 * FLICR_STATUS_STATE_TOO_SMALL, FLICR_STATUS_MISALIGNED, and any status that names a member of the configuration.
 */
flicr_status flicr_grid_encoder_init_store(void *state,
                                           size_t state_len,
                                           const struct flicr_grid_config *config,
                                           struct flicr_grid_encoder **out_encoder);

/**
 * As flicr_grid_encoder_init_store, for FLICR_CODER_RLE.
 */
flicr_status flicr_grid_encoder_init_rle(void *state,
                                         size_t state_len,
                                         const struct flicr_grid_config *config,
                                         struct flicr_grid_encoder **out_encoder);

/**
 * As flicr_grid_encoder_init_store, for FLICR_CODER_DEFLATE.
 */
flicr_status flicr_grid_encoder_init_deflate(void *state,
                                             size_t state_len,
                                             const struct flicr_grid_config *config,
                                             struct flicr_grid_encoder **out_encoder);

/**
 * As flicr_grid_encoder_init_store, for FLICR_CODER_DEFLATE_SMALL.
 */
flicr_status flicr_grid_encoder_init_deflate_small(void *state,
                                                   size_t state_len,
                                                   const struct flicr_grid_config *config,
                                                   struct flicr_grid_encoder **out_encoder);

/**
 * As flicr_grid_encoder_init_store, for FLICR_CODER_DEFLATE_DENSE.
 */
flicr_status flicr_grid_encoder_init_deflate_dense(void *state,
                                                   size_t state_len,
                                                   const struct flicr_grid_config *config,
                                                   struct flicr_grid_encoder **out_encoder);

/**
 * As flicr_grid_encoder_init_store, for FLICR_CODER_SMALL with these settings.
 *
 * FLICR_STATUS_CONTEXT.
 */
flicr_status flicr_grid_encoder_init_small(void *state,
                                           size_t state_len,
                                           const struct flicr_grid_config *config,
                                           const struct flicr_context *context,
                                           struct flicr_grid_encoder **out_encoder);

/**
 * As flicr_grid_encoder_init_small, for FLICR_CODER_DENSE.
 */
flicr_status flicr_grid_encoder_init_dense(void *state,
                                           size_t state_len,
                                           const struct flicr_grid_config *config,
                                           const struct flicr_context *context,
                                           struct flicr_grid_encoder **out_encoder);

/**
 * Puts returns into the frame that is open: `count` records, `stride_bytes` apart, each starting with a flicr_return,
 * at any alignment. Of the last record only these 12 bytes are read. Returns on a row or tick that the grid does not
 * have are counted as out of view.
 *
 * FLICR_STATUS_STRIDE, FLICR_STATUS_TOO_MANY_POINTS, FLICR_STATUS_OVERLAP: none of the returns are in the frame then.
 */
flicr_status flicr_insert_returns(struct flicr_grid_encoder *encoder,
                                  const void *returns,
                                  size_t count,
                                  size_t stride_bytes);

/**
 * Codes the frame of the returns so far to the front of `out`, and begins the next.
 *
 * FLICR_STATUS_OUTPUT_TOO_SMALL, never with FLICR_GRID_WORST_CASE_LEN bytes, and FLICR_STATUS_OVERLAP: the frame stays
 * open then, to be finished elsewhere.
 */
flicr_status flicr_finish_returns(struct flicr_grid_encoder *encoder,
                                  struct flicr_stamp stamp,
                                  void *out,
                                  size_t out_len,
                                  struct flicr_encoded *out_encoded);

/**
 * As flicr_insert_returns, with an intensity for each return: `numbers` are `count` of them, and that of a return that a
 * pixel keeps goes into planes->intensities.
 */
flicr_status flicr_insert_lit_returns(struct flicr_grid_encoder *encoder,
                                      const void *returns,
                                      size_t count,
                                      size_t stride_bytes,
                                      const uint8_t *numbers,
                                      const struct flicr_planes *planes);

/**
 * As flicr_finish_returns, with planes besides the ranges.
 *
 * FLICR_STATUS_PLANE; FLICR_STATUS_OUTPUT_TOO_SMALL, never with FLICR_PLANES_WORST_CASE_LEN bytes more than the frame
 * takes without.
 */
flicr_status flicr_finish_returns_with(struct flicr_grid_encoder *encoder,
                                       struct flicr_stamp stamp,
                                       const struct flicr_planes *planes,
                                       void *out,
                                       size_t out_len,
                                       struct flicr_encoded *out_encoded);

/**
 * Takes one UDP payload of the sensor. Where it ends a turn, FLICR_STATUS_OK: the turn's frame is at the front of
 * `out`, and what the packet holds of the next turn is kept. Until then FLICR_STATUS_TURN_OPEN.
 *
 * FLICR_STATUS_PACKET_REFUSED: the packet is not one of the sensor's, is damaged, late or doubled; nothing of it is
 * used, and it is counted. FLICR_STATUS_OUTPUT_TOO_SMALL, never with FLICR_GRID_WORST_CASE_LEN bytes: the turn is
 * lost, the next has begun. FLICR_STATUS_SENSOR: the configuration names no sensor whose packets are known.
 */
flicr_status flicr_push_packet(struct flicr_grid_encoder *encoder,
                               const void *packet,
                               size_t packet_len,
                               void *out,
                               size_t out_len,
                               struct flicr_turn *out_turn);

/**
 * Ends the turn that is open, as flicr_push_packet does; the next packet starts the stream anew.
 * FLICR_STATUS_TURN_OPEN where there was none.
 *
 * FLICR_STATUS_OUTPUT_TOO_SMALL, FLICR_STATUS_SENSOR.
 */
flicr_status flicr_finish_packets(struct flicr_grid_encoder *encoder,
                                  void *out,
                                  size_t out_len,
                                  struct flicr_turn *out_turn);

/**
 * Says what became of the packets so far.
 */
flicr_status flicr_get_packet_stats(struct flicr_grid_encoder *encoder, struct flicr_packet_stats *out_stats);

/**
 * What FLICR_PLANES_WORST_CASE_LEN gives: output bytes that are enough for intensities and times, besides those for the
 * frame without them. 0 where there can be no such frame.
 */
size_t flicr_planes_worst_case_len(uint32_t columns, uint32_t rows, uint32_t strips);

/**
 * Fills a configuration for a known sensor at its usual 600 turns a minute: lossless, the nearest return wins, the
 * beams are carried. columns: about as many as the sensor fires in a turn, or its ticks.
 *
 * FLICR_STATUS_SENSOR, for FLICR_SENSOR_CUSTOM too; FLICR_STATUS_SIZE.
 */
flicr_status flicr_grid_config_init(flicr_sensor sensor, uint32_t columns, struct flicr_grid_config *out_config);

/**
 * A sentence in English for a status; a sentence for numbers that are none, too. Never null, never to be freed.
 */
const char *flicr_status_text(flicr_status status);

/**
 * What FLICR_STREAM_SIZE gives: bytes that a stream takes. 0 where there can be none.
 */
size_t flicr_stream_size(uint32_t beams, flicr_coder coder, uint32_t aligned);

/**
 * Makes a stream with FLICR_CODER_SMALL, columns as fired, in memory of at least
 * FLICR_STREAM_SIZE(config->beam_count, FLICR_CODER_SMALL, 0) bytes, aligned to FLICR_ENCODER_ALIGN. `id` says which of
 * the sender's streams it is, where several go to one receiver: 0 to 255.
 *
 * Of the configuration count the sensor, its beams and grid, `returns`, and `step_m`, the distance of the levels: 1 to
 * 255 range units; a level has 16 bits. The receiver must know the sensor's grid, with the same `turns_per_minute`.
 *
 * FLICR_STATUS_STATE_TOO_SMALL, FLICR_STATUS_MISALIGNED, FLICR_STATUS_CONTEXT, FLICR_STATUS_STEP, FLICR_STATUS_SIZE for
 * the `id` too, and any status that names a member of the configuration.
 */
flicr_status flicr_stream_init_small(void *state,
                                     size_t state_len,
                                     const struct flicr_grid_config *config,
                                     const struct flicr_context *context,
                                     uint32_t id,
                                     struct flicr_stream **out_stream);

/**
 * As flicr_stream_init_small, for FLICR_CODER_DENSE.
 */
flicr_status flicr_stream_init_dense(void *state,
                                     size_t state_len,
                                     const struct flicr_grid_config *config,
                                     const struct flicr_context *context,
                                     uint32_t id,
                                     struct flicr_stream **out_stream);

/**
 * As flicr_stream_init_small, for columns that are aligned: beams that fire together look apart, and a column is made of
 * what looks one way. Fewer bytes, later by as many firings as lie between the first beam and the last, in memory of
 * FLICR_STREAM_SIZE(config->beam_count, FLICR_CODER_SMALL, 1) bytes. config->columns says how many firings a turn has,
 * about.
 *
 * FLICR_STATUS_DELAY where the sensor's beams look farther apart than there is room for.
 */
flicr_status flicr_stream_init_small_aligned(void *state,
                                             size_t state_len,
                                             const struct flicr_grid_config *config,
                                             const struct flicr_context *context,
                                             uint32_t id,
                                             struct flicr_stream **out_stream);

/**
 * As flicr_stream_init_small_aligned, for FLICR_CODER_DENSE.
 */
flicr_status flicr_stream_init_dense_aligned(void *state,
                                             size_t state_len,
                                             const struct flicr_grid_config *config,
                                             const struct flicr_context *context,
                                             uint32_t id,
                                             struct flicr_stream **out_stream);

/**
 * Takes one UDP payload of the sensor; calls `send` with each datagram that it fills.
 *
 * FLICR_STATUS_PACKET_REFUSED: the packet is not one of the sensor's, is damaged, late or doubled; nothing of it is
 * used, and it is counted. FLICR_STATUS_SENSOR: the configuration names no sensor whose packets are known.
 */
flicr_status flicr_stream_push_packet(struct flicr_stream *stream,
                                      const void *packet,
                                      size_t packet_len,
                                      flicr_send send,
                                      void *context);

/**
 * Takes a firing that a driver has read already: `count` range counts, from the highest beam on, 0 where nothing came
 * back; beams that are left out have no return. Calls `send` with each datagram that this fills.
 *
 * FLICR_STATUS_SIZE for an index above 8191 or more counts than beams, FLICR_STATUS_TICKS for a tick above 65535.
 */
flicr_status flicr_stream_push_column(struct flicr_stream *stream,
                                      const struct flicr_column *column,
                                      const uint32_t *counts,
                                      size_t count,
                                      flicr_send send,
                                      void *context);

/**
 * Ends the turn that is open: what is coded of it goes out, and the receiver is told that no more will come.
 * flicr_stream_push_packet does it by itself; a driver that pushes columns does it here.
 */
flicr_status flicr_stream_end_turn(struct flicr_stream *stream, flicr_send send, void *context);

/**
 * No more will come, or nothing for a while: all that is held goes out, and the turn is over. The next packet starts
 * anew.
 */
flicr_status flicr_stream_finish(struct flicr_stream *stream, flicr_send send, void *context);

/**
 * Keeps ranges in other steps: from the next turn on, or, with `now` other than 0, from the next datagram on.
 *
 * FLICR_STATUS_CONTEXT.
 */
flicr_status flicr_stream_set_context(struct flicr_stream *stream, const struct flicr_context *context, uint32_t now);

/**
 * Keeps one column of `stride`, 1 to 255, from the next turn on.
 *
 * FLICR_STATUS_SIZE.
 */
flicr_status flicr_stream_set_stride(struct flicr_stream *stream, uint32_t stride);

/**
 * Leaves out what is left of the turn: where a link has no more room for it.
 */
flicr_status flicr_stream_cut(struct flicr_stream *stream);

/**
 * Says what has become of the firings so far.
 */
flicr_status flicr_stream_get_tally(struct flicr_stream *stream, struct flicr_stream_tally *out_tally);

/**
 * Says what became of the packets so far.
 */
flicr_status flicr_stream_get_packet_stats(struct flicr_stream *stream, struct flicr_packet_stats *out_stats);

/**
 * Writes a datagram as it goes over a byte stream, a UART: between zeros, and without zeros in it. FLICR_FRAMED_LEN
 * bytes are enough.
 *
 * FLICR_STATUS_OUTPUT_TOO_SMALL, FLICR_STATUS_OVERLAP.
 */
flicr_status flicr_frame_datagram(const void *datagram,
                                  size_t datagram_len,
                                  void *out,
                                  size_t out_len,
                                  size_t *out_framed_len);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* FLICR_H */
