// update_golden RESULTS GOLDEN PICTURES: prints what differs by more than allowed, then replaces GOLDEN.
#include <iostream>

#include "regression/golden.h"

int main(int argc, char** argv) {
  using namespace truescatter::test;
  if (argc != 4) {
    std::cerr << "update_golden RESULTS GOLDEN PICTURES\n";
    return 2;
  }
  try {
    const Outcome fresh = read_results(argv[1]);
    if (std::filesystem::exists(argv[2])) {
      for (const std::string& change : changes(read_golden(argv[2]), fresh, argv[3]))
        std::cout << change << '\n';
    }
    std::filesystem::remove_all(argv[2]);
    write_golden(fresh, argv[2]);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 3;
  }
}
