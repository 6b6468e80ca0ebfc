#include "cli/command.h"

int main(int argc, char** argv) { return kinemesh::cli::run_program(argc, argv); }
