// Rows of random numbers to gripd over TCP, packed as f32, and the slips that come back: docs/rows.md
#include <arpa/inet.h>
#include <chrono>
#include <iostream>
#include <random>
#include <string>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

int main() {
  sockaddr_in gripd{};
  gripd.sin_family = AF_INET;
  gripd.sin_port = htons(7750);
  gripd.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int line = socket(AF_INET, SOCK_STREAM, 0);
  if (connect(line, reinterpret_cast<sockaddr *>(&gripd), sizeof gripd) != 0) return 1;

  std::thread events([line] {
    char byte;
    for (std::string text; read(line, &byte, 1) == 1; text += byte) {
      if (byte != '\n') continue;
      if (text.find("\"type\":\"slip\"") != text.npos) std::cout << text << std::endl;
      text.clear();
    }
  });
  const std::string header = "vibration,rate=1600,format=f32\n";
  if (write(line, header.data(), header.size()) < 0) return 1;
  std::mt19937 random(1);
  auto due = std::chrono::steady_clock::now();
  for (int n = 0; n < 3200; n++, due += std::chrono::microseconds(625)) {
    std::this_thread::sleep_until(due);
    std::normal_distribution<float> sensor(0, 2400 <= n && n < 2560 ? 0.1f : 0.01f);
    const float value = sensor(random);  // here your sensor; this computer is little endian
    if (write(line, &value, sizeof value) < 0) break;
  }
  shutdown(line, SHUT_WR);
  events.join();
}
