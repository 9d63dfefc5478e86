#include <stdint.h>

// The label of an image (wire/board_image.h): mark, board, version, first byte, end. Behind the
// vectors, in a gap that the linker is told to leave. Numbers are little endian, which this chip is
// not, so they are bytes. The image is filled up to the end of the flash: its end is known here.

#define ADDRESS_BYTES(address) {(address) & 0xFF, (address) >> 8, 0, 0}

typedef struct {
  char mark[8];
  char board[24];
  char version[16];
  uint8_t begin[4];
  uint8_t end[4];
} Label;

const __at(SINEW_LABEL_ADDRESS) Label sinew_label = {{'S', 'I', 'N', 'E', 'W', '-', 'F', 'W'},
                                                     SINEW_BOARD,
                                                     SINEW_VERSION,
                                                     ADDRESS_BYTES(SINEW_FLASH_BEGIN),
                                                     ADDRESS_BYTES(SINEW_FLASH_END)};
