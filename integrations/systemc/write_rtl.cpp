// Writes the SystemVerilog of a configuration: write_rtl FILE.toml FOLDER.
#include "../check.hpp"


int main(int argc, char **argv) {
  if (argc != 3) {
    std::cerr << "write_rtl: expected FILE.toml FOLDER\n";
    return 2;
  }
  value(value(raypath::Datapath::open(read_file(argv[1]).c_str())).generate(argv[2]));
}
