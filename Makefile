# SPDX-License-Identifier: Apache-2.0
# Thin: every rule calls cmake, ctest, a script or the program. `make help` lists them.
SHELL := /bin/bash
PRESET ?= release
BUILD := build/$(PRESET)
RASTRO := $(BUILD)/rastro
JOBS ?= $(shell nproc)
DEMO := results/demo

.PHONY: help build demo test sanitize bench format check-layers pages deps configure

build: configure  ## compile everything into build/release (PRESET=dev, asan, ... for another preset)
	cmake --build $(BUILD) --parallel $(JOBS)

help:  ## this list
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 16

deps:  ## install the Debian packages a build needs (quick when nothing is missing)
	@scripts/install-deps

configure: deps
	@cmake --preset $(PRESET)

demo: configure  ## generate three worlds, track and map them, score the results; pictures, video, maps and tables in results/demo
	cmake --build $(BUILD) --parallel $(JOBS) --target rastro_program
	@scripts/demo $(RASTRO) $(DEMO)

test: build  ## build and run every test
	ctest --preset $(PRESET) --parallel $(JOBS)

sanitize: deps  ## build and run every test under AddressSanitizer and UndefinedBehaviorSanitizer (half an hour)
	@cmake --preset asan
	cmake --build build/asan --parallel $(JOBS)
	ASAN_OPTIONS=detect_leaks=1:strict_string_checks=1 UBSAN_OPTIONS=print_stacktrace=1 LSAN_OPTIONS=suppressions=$(CURDIR)/cmake/lsan-suppressions.txt \
	  ctest --preset asan --parallel $(JOBS) --label-exclude release_only

bench: build  ## micro-benchmarks; the table of docs/benchmarks.md names the command of each figure
	@for program in $(BUILD)/rastro_*_bench; do echo "== $$program"; $$program || exit 1; done

format:  ## format every source in place
	@scripts/format

pages: build  ## write docs/reference-options.md from the option tables
	@scripts/option_pages.py $(RASTRO)

check-layers:  ## check the includes against layers.txt
	@scripts/check_layers.py
