// Stands in for an Arduino: Serial is the standard output, and the clock overflows after half a second.
#pragma once
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <unistd.h>

constexpr unsigned STEP_US = 9615;
inline unsigned samples = 0;

inline unsigned long micros() { return uint32_t(samples * STEP_US - 500000u); }

struct {
  bool is_open = false;
  void begin(unsigned long baud) { is_open = baud == 500000; }
  void write(const char *text) {
    if (!is_open) abort();
    fputs(text, stdout);
  }
  void print(char character) {
    const char text[] = {character, 0};
    write(text);
  }
  void print(unsigned long number) {
    char text[24];
    snprintf(text, sizeof text, "%lu", number);
    write(text);
  }
  void print(double number, int digits) {
    char text[64];
    snprintf(text, sizeof text, "%.*f", digits, number);
    write(text);
  }
  void println(const char *text = "") {
    write(text);
    write("\r\n");
    if (fflush(stdout)) exit(1);
  }
} Serial;

void setup();
void loop();

int main() {
  setup();
  for (;;) loop();
}
