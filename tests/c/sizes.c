/* What the header's macros give, for tests/c_client.rs to compare with the library's functions. As C99 and as C++. */
#include <stdio.h>

#include "flicr.h"

/* Constants, or these would not compile. */
static uint64_t memory[FLICR_ENCODER_WORDS(4500, 64, FLICR_CODER_RLE)];
static uint8_t frame[FLICR_WORST_CASE_LEN(4500, 64, FLICR_CODER_RLE)];

static void print_sizes(unsigned columns, unsigned rows, flicr_coder coder) {
  printf("%u %u %u %lu %lu %lu\n", columns, rows, (unsigned)coder, (unsigned long)FLICR_ENCODER_SIZE(columns, rows, coder),
         (unsigned long)FLICR_WORST_CASE_LEN(columns, rows, coder),
         (unsigned long)FLICR_ENCODER_WORDS(columns, rows, coder));
}

/* Before the sizes on a grid: level bits. */
static void print_grid_sizes(unsigned columns, unsigned beams, unsigned level_bits, flicr_coder coder) {
  printf("%u %u %u %u %lu %lu %lu\n", level_bits, columns, beams, (unsigned)coder,
         (unsigned long)FLICR_GRID_ENCODER_SIZE(columns, beams, level_bits, coder),
         (unsigned long)FLICR_GRID_WORST_CASE_LEN(columns, beams, level_bits, coder),
         (unsigned long)FLICR_GRID_ENCODER_WORDS(columns, beams, level_bits, coder));
}

/* After the rest: strips. */
static void print_strips(unsigned columns, unsigned rows, unsigned level_bits, flicr_coder coder, unsigned strips) {
  printf("%u %u %u %u %u %lu %lu %u\n", level_bits, columns, rows, (unsigned)coder, strips,
         (unsigned long)FLICR_WORST_CASE_LEN_IN_STRIPS(columns, rows, coder, strips),
         (unsigned long)FLICR_GRID_WORST_CASE_LEN_IN_STRIPS(columns, rows, level_bits, coder, strips), strips);
}

/* Of a stream; behind its three numbers three that say that it is one. */
static void print_stream_sizes(unsigned beams, flicr_coder coder, unsigned aligned) {
  printf("%u %u %u 0 0 0 %lu 0 %lu\n", beams, (unsigned)coder, aligned,
         (unsigned long)FLICR_STREAM_SIZE(beams, coder, aligned), (unsigned long)FLICR_STREAM_WORDS(beams, coder, aligned));
}

int main(void) {
  static const unsigned COLUMNS[] = {4500, 4096, 2048, 1024, 512, 256, 1, 3, 127, 129, 65535};
  static const flicr_coder CODERS[] = {FLICR_CODER_STORE, FLICR_CODER_RLE, FLICR_CODER_DEFLATE,
                                       FLICR_CODER_DEFLATE_SMALL, FLICR_CODER_DEFLATE_DENSE, FLICR_CODER_SMALL,
                                       FLICR_CODER_DENSE};
  for (unsigned i = 0; i < sizeof COLUMNS / sizeof COLUMNS[0]; i++)
    for (unsigned j = 0; j < sizeof CODERS / sizeof CODERS[0]; j++) {
      print_sizes(COLUMNS[i], 64, CODERS[j]);
      print_sizes(COLUMNS[i], 1, CODERS[j]);
      for (unsigned strips = 1; strips <= 16 && strips <= COLUMNS[i]; strips += 3)
        for (unsigned bits = 8; bits <= 9; bits++) print_strips(COLUMNS[i], 64, bits, CODERS[j], strips);
      for (unsigned bits = 1; bits <= 16; bits++) print_grid_sizes(COLUMNS[i], 16 + bits * 7, bits, CODERS[j]);
    }
  for (unsigned beams = 1; beams <= 128; beams++)
    for (unsigned aligned = 0; aligned < 2; aligned++) {
      print_stream_sizes(beams, FLICR_CODER_SMALL, aligned);
      print_stream_sizes(beams, FLICR_CODER_DENSE, aligned);
    }
  printf("version %lu align %d memory %lu frame %lu\n", (unsigned long)FLICR_VERSION, FLICR_ENCODER_ALIGN,
         (unsigned long)sizeof memory, (unsigned long)sizeof frame);
  return memory[0] != frame[0];
}
