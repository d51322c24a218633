/*
 * A VLP-16's packets from UDP to datagrams by UDP, as the sensor turns, from C. With a receiver:
 *
 *     flicr receive udp://127.0.0.1:7502 --sensor vlp16
 *     tools/staticlib.sh x86_64-unknown-linux-gnu        (prints where the library lies)
 *     cc -std=c99 -Iinclude examples/c/stream.c LIBRARY -o stream
 *     ./stream 2368 127.0.0.1 7502
 *
 * 2368 is the port of the packets, as the sensor sends them; 0 takes any that is free. It is printed. An empty packet
 * ends the program.
 */
#define _POSIX_C_SOURCE 200112L
#include <arpa/inet.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "flicr.h"

#define BEAMS 16
#define STEP_M 0.02f
#define PACKET_MAX 1500

/* All memory that flicr needs, sized at compile time: less than 6 KB. */
static uint64_t memory[FLICR_STREAM_WORDS(BEAMS, FLICR_CODER_SMALL, 0)];

typedef struct link {
  int socket;
  struct sockaddr_in to;
  unsigned lost;
} link_to;

static void fail(const char *what, const char *why) {
  fprintf(stderr, "%s: %s\n", what, why);
  exit(1);
}

static void check(const char *what, flicr_status status) {
  if (status != FLICR_STATUS_OK) fail(what, flicr_status_text(status));
}

static struct sockaddr_in address(const char *host, const char *port) {
  struct sockaddr_in found;
  char *end;
  unsigned long number = strtoul(port, &end, 10);
  memset(&found, 0, sizeof found);
  found.sin_family = AF_INET;
  found.sin_port = htons((uint16_t)number);
  if (*end || number > 65535) fail(port, "no port");
  if (inet_pton(AF_INET, host, &found.sin_addr) != 1) fail(host, "no IPv4 address");
  return found;
}

static int open_socket(void) {
  int opened = socket(AF_INET, SOCK_DGRAM, 0);
  if (opened < 0) fail("socket", strerror(errno));
  return opened;
}

/* Packets come in bursts; what does not fit the socket's buffer would be lost. */
static int listen_at(const char *port) {
  struct sockaddr_in at = address("127.0.0.1", port);
  socklen_t len = sizeof at;
  int bytes = 4 << 20, listening = open_socket();
  setsockopt(listening, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
  if (bind(listening, (struct sockaddr *)&at, sizeof at) != 0) fail(port, strerror(errno));
  if (getsockname(listening, (struct sockaddr *)&at, &len) != 0) fail(port, strerror(errno));
  printf("listening on %u\n", (unsigned)ntohs(at.sin_port));
  fflush(stdout);
  return listening;
}

/* A datagram that the link does not take is lost, and nothing else with it. */
static void send_datagram(void *context, const uint8_t *datagram, size_t len) {
  link_to *link = context;
  ssize_t sent = sendto(link->socket, datagram, len, 0, (struct sockaddr *)&link->to, sizeof link->to);
  if (sent != (ssize_t)len) link->lost++;
}

int main(int argc, char **argv) {
  flicr_grid_config config;
  flicr_context context;
  flicr_stream *stream;
  flicr_stream_tally tally;
  flicr_packet_stats stats;
  uint8_t packet[PACKET_MAX];
  link_to link = {0};
  if (argc != 4) fail("usage", "stream PORT TO_HOST TO_PORT");
  if (flicr_version() != FLICR_VERSION) fail("flicr", "header and library are of different versions");
  check("configuration", flicr_grid_config_init(FLICR_SENSOR_VLP16, 1800, &config));
  check("context", flicr_context_init(config.step_m, STEP_M, &context));
  check("stream", flicr_stream_init_small(memory, sizeof memory, &config, &context, 0, &stream));
  link.to = address(argv[2], argv[3]);
  link.socket = open_socket();
  int listening = listen_at(argv[1]);
  for (;;) {
    ssize_t len = recv(listening, packet, sizeof packet, 0);
    if (len < 0) fail("packets", strerror(errno));
    if (len == 0) break;
    /* One that is refused is counted; the stream goes on. */
    (void)flicr_stream_push_packet(stream, packet, (size_t)len, send_datagram, &link);
  }
  check("end", flicr_stream_finish(stream, send_datagram, &link));
  check("tally", flicr_stream_get_tally(stream, &tally));
  check("packets", flicr_stream_get_packet_stats(stream, &stats));
  printf("%u packets used, %u refused; %lu returns in %u columns; %u datagrams of %lu bytes, %u not sent\n",
         (unsigned)stats.used, (unsigned)stats.refused, (unsigned long)tally.returns, (unsigned)tally.columns,
         (unsigned)tally.datagrams, (unsigned long)tally.bytes, link.lost);
  close(listening);
  close(link.socket);
  return 0;
}
