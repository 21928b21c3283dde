// Checks of the tests in this folder. Unlike assert, they are never compiled out.
#pragma once

#include <raypath.hpp>

#include <cstddef>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

template <typename Found, typename Expected>
void check_equal(const Found &found, const Expected &expected, const char *what, const char *file, int line) {
  if (found == static_cast<Found>(expected)) return;
  std::cerr << file << ':' << line << ": " << what << " is " << found << ", expected " << expected << '\n';
  std::exit(1);
}

#define CHECK_EQUAL(found, expected) check_equal(found, expected, #found, __FILE__, __LINE__)

inline std::string read_file(const char *path) {
  std::ifstream file(path);
  if (!file) {
    std::cerr << path << " cannot be read\n";
    std::exit(1);
  }
  return std::string(std::istreambuf_iterator<char>(file), {});
}

/// Prints the row of a table that a page contains. Exits if the page has another one.
template <typename... Cells>
void check_row(const std::string &page, const Cells &...cells) {
  std::string row = "|";
  ((row += ' ' + std::to_string(cells) + " |"), ...);
  std::cout << row << '\n';
  if (page.find('\n' + row + '\n') != std::string::npos) return;
  std::cerr << "the page of this adapter does not have the row " << row << '\n';
  std::exit(1);
}

/// The value of a call that must succeed.
template <typename T>
T value(raypath::Expected<T> expected) {
  if (expected) return *std::move(expected);
  std::cerr << expected.error().message << '\n';
  std::exit(1);
}

inline std::vector<raypath::Pipeline> pipelines(const char *configuration, std::size_t count) {
  const raypath::Datapath datapath = value(raypath::Datapath::open(configuration));
  std::vector<raypath::Pipeline> made;
  while (made.size() < count) made.push_back(value(raypath::Pipeline::create(datapath)));
  return made;
}
