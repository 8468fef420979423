# The one entry. `make help` lists what there is.
SHELL := /bin/bash
.DEFAULT_GOAL := all
.DELETE_ON_ERROR:
MAKEFLAGS += --no-builtin-rules

PYTHON ?= python3
VENV := .venv
BUILD := .build
RESULTS := .results
NATIVE := harness/aliascope/native
LIBRARIES := $(NATIVE)/lib
VERSION := $(shell sed -n 's/^version = "\(.*\)"/\1/p' pyproject.toml)

# VARIANT=sanitized builds the C tests again under the address, leak and undefined-behaviour sanitizers, VARIANT=threads
# those that start threads under the thread sanitizer, VARIANT=fuzz by clang under the first of these and with the
# counters of libFuzzer.
VARIANT ?= release
OBJECTS := $(BUILD)/$(VARIANT)
WARNINGS := -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror
# The same file whatever the folder: its hash is in the keys of pictures, and its debugging information names no path.
PATHS := '-ffile-prefix-map=$(CURDIR)=.'
# Contraction off: the same bits on machines with and without fused multiply-add. The library uses neither errno nor
# floating-point traps, which would keep loops with conditions from being vectorised.
CFLAGS := -std=c11 -O3 -g -fPIC -fvisibility=hidden -ffp-contract=off -fno-math-errno -fno-trapping-math -pthread $(PATHS) $(WARNINGS)
SANITIZERS := address,undefined,float-divide-by-zero,float-cast-overflow
ifeq ($(VARIANT),sanitized)
CFLAGS += -O1 -fno-omit-frame-pointer -fsanitize=$(SANITIZERS) -fno-sanitize-recover=all
endif
ifeq ($(VARIANT),fuzz)
CC := clang
# Without the values of comparisons, which take most of the time where there is arithmetic.
CFLAGS += -O1 -fno-omit-frame-pointer -fsanitize=fuzzer-no-link,$(SANITIZERS) -fno-sanitize-recover=all \
  -fno-sanitize-coverage=trace-cmp -Wno-bitwise-instead-of-logical
endif
ifeq ($(VARIANT),threads)
CFLAGS += -O1 -fno-omit-frame-pointer -fsanitize=thread
endif
CPPFLAGS := -Icsrc/include -Icsrc/sampler -Icsrc/filter -Icsrc/discrepancy -Icsrc/warp -Icsrc/estimate -Icsrc/tracer -Icsrc/raster -DASC_VERSION='"$(VERSION)"' -MMD -MP
EMBREE := -lembree3
OSMESA := -lOSMesa

# What builds a package says with which Python, one that has cffi; then nothing is installed. Modules that are there
# serve any.
ifdef CFFI_PYTHON
BINDER := $(CFFI_PYTHON)
INSTALLED :=
else
BINDER := $(VENV)/bin/python
INSTALLED := $(BUILD)/venv.stamp
SYSTEM := $(BUILD)/system.stamp
endif

# Tests run side by side.
CORES := $(shell nproc)
TOGETHER := --jobs=$(CORES) --output-sync=target

say = echo "  $(1) $@"
objects = $(patsubst csrc/%.c,$(OBJECTS)/%.o,$(wildcard csrc/$(1)/*.c))
LIBRARY_OBJECTS := $(foreach part,sampler filter discrepancy warp estimate,$(call objects,$(part)))
TRACER_OBJECTS := $(call objects,tracer)
# Where what moves is at a time, the two renderers say by the same code.
RASTER_OBJECTS := $(call objects,raster) $(OBJECTS)/tracer/motion.o
C_TEST_SOURCES := $(wildcard tests/c/test_*.c)
ifeq ($(VARIANT),threads)
C_TEST_SOURCES := $(shell grep -l threads_alone.h $(C_TEST_SOURCES))
endif
C_TESTS := $(patsubst tests/c/%.c,$(OBJECTS)/%,$(C_TEST_SOURCES))
FUZZ_TARGETS := $(patsubst tests/fuzz/%.c,$(OBJECTS)/%,$(wildcard tests/fuzz/fuzz_*.c))
C_BENCHES := $(patsubst tests/bench/%.c,$(OBJECTS)/%,$(wildcard tests/bench/bench_*.c))
KEPT_RAYS := $(OBJECTS)/kept_rays.so
BINDINGS := $(BUILD)/bindings.stamp
PLUGIN := $(BUILD)/plugins/kronecker.so
DEFECTIVE := $(BUILD)/plugins/repeats.so
# Lies with the package: `aliascope stability` loads it.
NOT_FINITE := $(NATIVE)/not_finite.so
EMBREE_ISA := $(BUILD)/embree_isa.so
# What is installed carries the major version, as programs that were linked with it keep to that ABI. The Python package
# has its own copy, under a plain name.
SONAME := libaliascope.so.$(firstword $(subst ., ,$(VERSION)))
VERSIONED := $(BUILD)/install/libaliascope.so.$(VERSION)

## all        install what is missing, build the libraries and the command .venv/bin/aliascope
.PHONY: all
all: $(BINDINGS) $(PLUGIN) $(NOT_FINITE) $(VERSIONED)

## compare    render the quick profile and write the report
.PHONY: compare
compare: all
	@$(VENV)/bin/aliascope compare --profile quick -o $(RESULTS)/compare

## knobs      measure what each setting does to time and error; results in .results/knobs
.PHONY: knobs
knobs: all
	@$(VENV)/bin/aliascope knobs -o $(RESULTS)/knobs

## mitchell   measure Mitchell's table of random edges again, and write its page
.PHONY: mitchell
mitchell: all
	@$(VENV)/bin/aliascope mitchell -o $(RESULTS)/mitchell

## agree      test whether the renderers' converged pictures of every scene agree
.PHONY: agree
agree: all
	@$(VENV)/bin/aliascope agree -o $(RESULTS)/agree

## stability  find where each part breaks at the extremes; results in .build/stability
.PHONY: stability
stability: all
	@$(VENV)/bin/aliascope stability -j $(CORES) -o $(BUILD)/stability

## regress    test that pictures are as good as they were blessed; results in .results/regress
.PHONY: regress
regress: all
	@$(VENV)/bin/aliascope regress -o $(RESULTS)/regress

## power      false alarms of regress, and the defects that it catches: measured; half an hour the first time
.PHONY: power
power: all $(DEFECTIVE) $(EMBREE_ISA)
	@$(VENV)/bin/aliascope power --trust-plugin $(DEFECTIVE) --shim $(EMBREE_ISA) -j $(CORES) -o $(RESULTS)/power

## test       every test: C (also under sanitizers: addresses, leaks, threads), Python, browser
.PHONY: test
test: all
	$(MAKE) --no-print-directory $(TOGETHER) c-tests
	$(MAKE) --no-print-directory $(TOGETHER) c-tests VARIANT=sanitized
	$(MAKE) --no-print-directory $(TOGETHER) c-tests VARIANT=threads
	$(VENV)/bin/pytest --numprocesses $(CORES) --dist loadfile

## fuzz       feed the parsers, the samplers, the measures and the readers of files with any bytes: SECONDS=60 of each
SECONDS ?= 60
.PHONY: fuzz
fuzz: all
	@$(MAKE) --no-print-directory $(TOGETHER) fuzz-targets VARIANT=fuzz
	@$(VENV)/bin/python tests/fuzz/run.py --seconds $(SECONDS) --at-once $(CORES) $(TARGETS)

## faults     kill compare, its workers and POV-Ray at 200 moments, and go on from each
.PHONY: faults
faults: all
	@$(VENV)/bin/python tests/python/killed_compares.py --kills 200

## load       a compare of 10,000 small jobs, which has to keep its memory level
.PHONY: load
load: all
	@$(VENV)/bin/python tests/bench/load.py

## lint       formatters, linters, types, layers
.PHONY: lint
lint: all
	clang-format --dry-run --Werror $(shell git ls-files 'csrc/*.[ch]' 'tests/*.[ch]' | grep -v sobol_directions.c)
	clang-tidy --quiet $(shell git ls-files 'csrc/*.c') -- -std=c11 $(filter -I% -D%,$(CPPFLAGS)) 2> >(grep -v 'warnings generated' >&2)
	$(VENV)/bin/ruff format --check --quiet
	$(VENV)/bin/ruff check --quiet
	$(VENV)/bin/mypy
	$(VENV)/bin/lint-imports --no-logo
	shellcheck harness/*.sh .ci/run

## bench      nanoseconds a dimension, SciPy beside, the tracer's share of bare Embree, the harness's time a job
.PHONY: bench
bench: all $(C_BENCHES) $(KEPT_RAYS)
	@for bench in $(C_BENCHES); do $$bench || exit 1; done
	@$(VENV)/bin/python tests/bench/bench_scenes.py $(KEPT_RAYS)
	@$(VENV)/bin/python tests/bench/bench_safeguards.py
	@$(VENV)/bin/python tests/bench/bench_plugins.py $(PLUGIN)
	@$(VENV)/bin/python tests/bench/bench_peers.py
	@$(VENV)/bin/python tests/bench/bench_harness.py

## install    the C library, its headers and its pkg-config file, to $(DESTDIR)$(prefix)
prefix ?= /usr/local
.PHONY: install
install: TO = $(if $(filter /%,$(firstword $(prefix))),$(DESTDIR)$(prefix),$(error prefix is a full path: $(prefix) is none))
install: $(VERSIONED)
	@install -d "$(TO)/include/aliascope" "$(TO)/lib/pkgconfig"
	@install -m 644 $(filter-out %/scene.h,$(wildcard csrc/include/aliascope/*.h)) "$(TO)/include/aliascope"
	@install -m 755 $(VERSIONED) "$(TO)/lib"
	@ln -sf $(notdir $(VERSIONED)) "$(TO)/lib/$(SONAME)"
	@ln -sf $(SONAME) "$(TO)/lib/libaliascope.so"
	@sed 's|@prefix@|$(subst |,\|,$(subst &,\&,$(prefix)))|; s|@version@|$(VERSION)|' csrc/aliascope.pc.in >"$(TO)/lib/pkgconfig/aliascope.pc"
	@echo "installed libaliascope $(VERSION) to $(TO)"

## wheel      the Python package, with libraries, scenes and references, as a wheel and as sources, to $(DIST)
DIST ?= $(BUILD)/dist
.PHONY: wheel
wheel: all
	@$(VENV)/bin/python -m pip wheel --quiet --disable-pip-version-check --no-build-isolation --no-deps -w "$(DIST)" .
	@$(VENV)/bin/python -c 'from setuptools.build_meta import build_sdist; build_sdist("$(DIST)")' >/dev/null
	@ls "$(DIST)"/aliascope-$(VERSION)*

# What the build of the package asks for, with CFFI_PYTHON.
.PHONY: native
native: $(BINDINGS) $(NOT_FINITE)

## clean      remove everything that was built; packages that were downloaded, and results of compare, stay
.PHONY: clean
clean:
	rm -rf $(BUILD) $(LIBRARIES) $(NATIVE)/*.so harness/aliascope.egg-info

## distclean  remove .venv, the Python packages, too
.PHONY: distclean
distclean: clean
	rm -rf $(VENV)

.PHONY: help
help:
	@sed -n 's/^## /make /p' Makefile

# --- packages ---------------------------------------------------------------------------------------------------------

$(BUILD)/system.stamp: harness/system-packages.txt harness/install-system-packages.sh
	@mkdir -p $(@D)
	@harness/install-system-packages.sh harness/system-packages.txt
	@touch $@

$(BUILD)/venv.stamp: harness/requirements.txt pyproject.toml $(BUILD)/system.stamp
	@echo "installing Python packages into $(VENV)"
	@test -x $(VENV)/bin/python || $(PYTHON) -m venv $(VENV)
	@$(VENV)/bin/python -m pip install --quiet --disable-pip-version-check --require-hashes -r harness/requirements.txt
	@$(VENV)/bin/python -m pip install --quiet --disable-pip-version-check --no-build-isolation --no-deps -e .
	@touch $@

# --- libraries and bindings -------------------------------------------------------------------------------------------

$(OBJECTS)/%.o: csrc/%.c Makefile | $(SYSTEM)
	@mkdir -p $(@D)
	@$(call say,compiling)
	@$(CC) $(CFLAGS) $(CPPFLAGS) -c $< -o $@

# The libraries are the release variant's; each names the folder it lies in as where to look for the others.
SHARED = @$(call say,linking) && $(CC) -shared $(CFLAGS) $(filter %.o,$^) -Wl,--no-undefined -Wl,-rpath,'$$ORIGIN' -L$(LIBRARIES) -o $@

# What libaliascope exports: the functions that the headers declare. Hidden visibility leaves out of account what the
# compiler adds where a function is compiled for several instruction sets.
EXPORTS := $(BUILD)/exports.map
$(EXPORTS): $(wildcard csrc/include/aliascope/*.h) Makefile
	@mkdir -p $(@D)
	@{ echo '{ global:'; sed -n 's/^ASC_API .*[ *]\(asc_[a-z0-9_]*\)(.*/\1;/p' $(filter %.h,$^); echo 'local: *; };'; } >$@

$(LIBRARIES)/libaliascope.so: $(LIBRARY_OBJECTS) $(EXPORTS)
	@mkdir -p $(@D)
	$(SHARED) -Wl,--version-script=$(EXPORTS) -Wl,-soname,libaliascope.so -lm -ldl

$(VERSIONED): $(LIBRARY_OBJECTS) $(EXPORTS)
	@mkdir -p $(@D)
	@$(call say,linking) && $(CC) -shared $(CFLAGS) $(filter %.o,$^) -Wl,--no-undefined -Wl,--version-script=$(EXPORTS) -Wl,-soname,$(SONAME) -o $@ -lm -ldl

$(LIBRARIES)/libaliascope-tracer.so: $(TRACER_OBJECTS) $(LIBRARIES)/libaliascope.so
	$(SHARED) -Wl,-soname,libaliascope-tracer.so -laliascope $(EMBREE) -lm

$(LIBRARIES)/libaliascope-raster.so: $(RASTER_OBJECTS) $(LIBRARIES)/libaliascope.so
	$(SHARED) -Wl,-soname,libaliascope-raster.so -laliascope $(OSMESA) -lm

# Calls nothing of ours; povray is started with it.
$(LIBRARIES)/libaliascope-waits.so: $(call objects,waits)
	@mkdir -p $(@D)
	$(SHARED) -ldl

ALL_LIBRARIES := $(addprefix $(LIBRARIES)/,libaliascope.so libaliascope-tracer.so libaliascope-raster.so libaliascope-waits.so)
HEADERS := $(wildcard csrc/include/aliascope/*.h) csrc/tracer/tracer.h csrc/raster/raster.h

$(BINDINGS): $(NATIVE)/build.py $(HEADERS) $(ALL_LIBRARIES) $(INSTALLED)
	@$(call say,building)
	@CC="$(CC)" $(BINDER) $(NATIVE)/build.py $(BUILD)/bindings
	@touch $@

# --- example plugin -----------------------------------------------------------------------------------------------------

$(BUILD)/plugins/%.so: csrc/plugins/%.c csrc/include/aliascope/*.h
	@mkdir -p $(@D)
	@$(call say,building)
	@$(CC) -shared $(filter-out -fsanitize%,$(CFLAGS)) -Icsrc/include $< -o $@ -lm

$(NOT_FINITE): csrc/plugins/not_finite.c csrc/include/aliascope/*.h
	@$(call say,building)
	@$(CC) -shared $(filter-out -fsanitize%,$(CFLAGS)) -Icsrc/include $< -o $@ -lm

# Of these that one alone calls the library.
$(DEFECTIVE): csrc/plugins/repeats.c csrc/include/aliascope/*.h $(LIBRARIES)/libaliascope.so
	@mkdir -p $(@D)
	@$(call say,building)
	@$(CC) -shared $(filter-out -fsanitize%,$(CFLAGS)) -Icsrc/include $< -L$(LIBRARIES) -laliascope -o $@

# --- C tests and benchmarks -------------------------------------------------------------------------------------------

# Leaks are looked for whatever the environment says. Each of these sanitizers has to find what is planted for it.
ifeq ($(VARIANT),sanitized)
SANITIZING := ASAN_OPTIONS=detect_leaks=1 LSAN_OPTIONS=suppressions=tests/c/leaks.supp:print_suppressions=0
PLANTED := planted_leak
else ifeq ($(VARIANT),threads)
SANITIZING := TSAN_OPTIONS=suppressions=tests/c/threads.supp:print_suppressions=0:halt_on_error=1 \
  $(shell setarch -R true 2>/dev/null && echo setarch -R)
PLANTED := planted_race
endif
FINDING_planted_leak := 123 byte(s) leaked
FINDING_planted_race := data race

.PHONY: c-tests $(C_TESTS:%=run-%) $(PLANTED:%=find-%)
c-tests: $(C_TESTS:%=run-%) $(PLANTED:%=find-%)

# The thread sanitizer does not start where the kernel chooses addresses from a wider range than it knows, unless it may
# be asked not to choose (setarch).
ifeq ($(VARIANT),threads)
NOT_STARTED := grep -qs 'unexpected memory mapping'
$(C_TESTS:%=run-%): run-%: %
	@$(SANITIZING) $< 2>$<.log || { failed=$$?; $(NOT_STARTED) $<.log \
	  && echo "  the thread sanitizer does not start here (vm.mmap_rnd_bits, setarch): not run $<" \
	  || { cat $<.log; exit $$failed; }; }
else
NOT_STARTED := false
c-tests: $(FUZZ_TARGETS:%=run-%)
$(C_TESTS:%=run-%): run-%: %
	@$(SANITIZING) $<
endif

$(PLANTED:%=find-%): find-%: $(OBJECTS)/%
	@$(SANITIZING) $< 2>$<.log; grep -qsF '$(FINDING_$*)' $<.log || $(NOT_STARTED) $<.log \
	  || { cat $<.log; echo "$<: the sanitizer has not found what is planted there"; exit 1; }

$(OBJECTS)/planted_%: tests/c/planted_%.c Makefile
	@$(call say,compiling)
	@$(CC) $(CFLAGS) -O0 $(CPPFLAGS) -MF $@.d $< -o $@

# Tests link the objects, to reach what is hidden.
$(OBJECTS)/test_%: tests/c/test_%.c $(LIBRARY_OBJECTS) $(TRACER_OBJECTS) $(RASTER_OBJECTS) Makefile
	@$(call say,compiling)
	@$(CC) $(CFLAGS) $(CPPFLAGS) -MF $@.d $< $(filter %.o,$^) -o $@ $(EMBREE) $(OSMESA) -lcmocka -lm -ldl

# Loads it.
$(OBJECTS)/test_remote: $(PLUGIN)

# --- fuzzing ------------------------------------------------------------------------------------------------------------

# Given by libFuzzer in its variant; in the others by a loop over the kept inputs, which is a test.
FUZZ_ENGINE := $(if $(filter fuzz,$(VARIANT)),-fsanitize=fuzzer,tests/fuzz/replay.c)

$(OBJECTS)/fuzz_%: tests/fuzz/fuzz_%.c tests/fuzz/replay.c $(LIBRARY_OBJECTS) $(TRACER_OBJECTS) Makefile
	@$(call say,compiling)
	@$(CC) $(CFLAGS) $(CPPFLAGS) -MF $@.d $< $(FUZZ_ENGINE) $(filter %.o,$^) -o $@ $(EMBREE) -lm -ldl

.PHONY: fuzz-targets $(FUZZ_TARGETS:%=run-%)
fuzz-targets: $(FUZZ_TARGETS)
$(FUZZ_TARGETS:%=run-%): run-%: %
	@ASAN_OPTIONS=allocator_may_return_null=1 LSAN_OPTIONS=suppressions=tests/c/leaks.supp:print_suppressions=0 $< $(wildcard tests/fuzz/corpus/$(patsubst fuzz_%,%,$(notdir $<))/*)

# Stands between the tracer and Embree: in the benchmark of C as an object, in Python's as a library.
$(OBJECTS)/kept_rays.o: tests/bench/kept_rays.c Makefile | $(SYSTEM)
	@mkdir -p $(@D)
	@$(call say,compiling)
	@$(CC) $(CFLAGS) $(CPPFLAGS) -c $< -o $@

$(KEPT_RAYS): $(OBJECTS)/kept_rays.o
	@$(call say,linking) && $(CC) -shared $(CFLAGS) $< -o $@ -Wl,--no-as-needed $(EMBREE) -ldl

$(OBJECTS)/bench_tracer: $(OBJECTS)/kept_rays.o

# Stands before Embree, to choose the instructions that it uses.
$(EMBREE_ISA): tests/c/embree_isa.c Makefile | $(SYSTEM)
	@$(call say,building)
	@$(CC) -shared $(filter-out -fsanitize%,$(CFLAGS)) $< -o $@ -Wl,--no-as-needed $(EMBREE) -ldl

$(OBJECTS)/bench_%: tests/bench/bench_%.c $(LIBRARY_OBJECTS) $(TRACER_OBJECTS) $(RASTER_OBJECTS) Makefile
	@$(call say,compiling)
	@$(CC) $(CFLAGS) $(CPPFLAGS) -MF $@.d $< $(filter %.o,$^) -o $@ $(EMBREE) $(OSMESA) -lm -ldl

-include $(shell find $(BUILD) -name '*.d' 2>/dev/null)
