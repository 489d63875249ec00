# A thin front door; the build itself is CMake (see CMakePresets.json and CONTRIBUTING.md).
.DEFAULT_GOAL := build
.PHONY: help deps deps-all build test demo bench compare one-file format tidy asan tsan arm fuzz attack coverage viewer package site clean

JOBS ?= $(shell nproc)
export JOBS
# make WERROR=OFF: for a compiler whose warnings we have not seen
ifdef WERROR
export CMAKE_ARGS += -DLOOPSTONE_WERROR=$(WERROR)
endif

help:      ## this list
	@sed -n 's/^\([a-z-]*\):.*## /  make \1\t/p' Makefile | expand -t 18

deps:
	@scripts/install_dependencies.sh
deps-all:
	@scripts/install_dependencies.sh --all

build: deps  ## the program at build/release/bin/loopstone
	@scripts/build.sh release

test: build  ## every test
	@scripts/test.sh release -j$(JOBS)

demo: deps  ## simulate an office, map it, compare with the truth
	@scripts/build.sh release loopstone_program
	@scripts/demo.sh

bench: deps-all  ## speed of the inner loops, and the tables of docs/
	@scripts/bench.sh

compare: deps  ## speed against BASE (a commit; else the parent of HEAD), on this machine
	@scripts/compare_speed.sh $(BASE)

format: deps-all  ## rewrite the sources by .clang-format
	@scripts/format.sh

tidy: deps-all  ## clang-tidy on everything
	@scripts/tidy_changed.sh --everything

asan: deps  ## every test under the address and undefined-behaviour sanitizers
	@scripts/build.sh asan
	@scripts/test.sh asan -j$(JOBS)

tsan: deps  ## what is threaded, under the thread sanitizer
	@scripts/tsan.sh

arm: deps  ## for 64-bit ARM: some tests under qemu, and whether the program writes the same bytes
	@scripts/arm.sh

fuzz: deps-all  ## each fuzz target for FUZZ_SECONDS (20)
	@scripts/fuzz.sh

attack: deps  ## ATTACK_INPUTS (20000) spoiled files a format; SANITIZE=1: under the sanitizers
	@scripts/attack.sh

coverage: deps  ## line coverage of the library by the tests
	@scripts/coverage.sh

viewer: deps-all  ## the page of the live view anew, viewer/built/index.html
	@scripts/build_viewer.sh

package: deps  ## Debian packages of program and library, build/release/packages
	@scripts/package.sh

one-file: deps  ## the program as one file that needs no library, build/release/one_file/loopstone
	@scripts/one_file.sh

site:      ## the documentation as a site, build/site/html
	@scripts/build_site.sh

clean:  ## remove build/
	rm -rf build
