# `make help` lists what there is. Scripts in tools/ do the work; each also runs alone.

SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
.PHONY: help setup demo test test-host test-evaluation test-aarch64 lint bench fuzz size live paper paper-quick package no-panic bless

# All that runs on a desk. defmt is not among them: its symbols exist only in firmware that has a logger.
FEATURES := std,cli,capi

# Tests that write what they compare with where FLICR_BLESS is set.
BLESSED := $(foreach test,qemu live capi context golden,$(if $(wildcard tests/$(test).rs),--test $(test)))

help: ## list the verbs
	@awk -F ':.*## ' '/^[a-z0-9-]+:.*## / { printf "  make %-14s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

setup: ## install what is missing: Rust targets, emulators, cross linkers
	@tools/setup.sh

demo: setup ## a scan through emulated firmware and back, with a table and a picture (FLICR_SCAN=path/to/kitti.bin)
	@tools/demo.sh

test: setup lint ## all checks: lint, tests on this machine, on emulated boards and AArch64 Linux, sizes
	@$(MAKE) --no-print-directory test-host test-evaluation test-aarch64 size

test-host: ## tests on this machine and on emulated boards
	@tools/step.sh "build of the tests" cargo test --quiet --no-run --features $(FEATURES)
	@FLICR_REQUIRE_QEMU=1 tools/step.sh "tests on this machine and on emulated boards" \
		cargo test --quiet --features $(FEATURES)

test-evaluation: ## the evaluation's own tests, and a quick run of it on a simulated scan, without other codecs
	@tools/step.sh "build of the program" cargo test --quiet --no-run --features $(FEATURES) --test cli
	@tools/paper.sh --test

# The tests that an emulator of AArch64 Linux runs: the library's and the C ABI's. Those that only start other programs
# would run these natively; calibration and shared scans would take it half an hour, so that they are kept from it.
EMULATED := --lib --test round_trip --test corrupt --test geometry --test lattice --test deflate --test docs_agree \
	--test metrics --test files --test simulate --test stream --test stream_modes --test sensor_file --test capi --test returns --test firings --test fast \
	--test context --test strips --test companding --test golden

test-aarch64: ## the library's tests as AArch64 Linux programs, under qemu-aarch64
	@tools/step.sh "build of the tests for AArch64 Linux" tools/cross.sh test --quiet --no-run \
		--features std,capi --target aarch64-unknown-linux-gnu $(EMULATED)
	@FLICR_DATA=/nonexistent PROPTEST_CASES=32 tools/step.sh "tests on emulated AArch64 Linux" tools/cross.sh test \
		--quiet --features std,capi --target aarch64-unknown-linux-gnu $(EMULATED)

lint: ## formatting, clippy for every feature and target, rustdoc
	@tools/lint.sh

bench: ## timings, each paired with a baseline in the same run; fails where Draco or cloudini come nearer than promised
	@tools/step.sh "benchmarks" cargo bench --quiet --features $(FEATURES)
	@tools/step.sh "beside Draco and cloudini" tools/bench.sh

fuzz: ## ten minutes of random input for each reader of untrusted bytes
	@tools/fuzz.sh

size: ## flash, RAM, stack and instructions of encoders of frames, and of streams on every target
	@tools/step.sh "size of the encoder on a Cortex-M" tools/size.sh
	@tools/step.sh "size of streams" tools/size_stream.sh

live: setup ## packets into emulated firmware and datagrams out of it, shown as they come (tools/live.sh says what can be chosen)
	@tools/live.sh

paper: ## the paper re-done beside other codecs, on FLICR_DATA's scans: target/paper/index.html
	@tools/paper.sh

paper-quick: ## the same on two scans, in fewer settings
	@tools/paper.sh --quick

package: ## the crate as it would be published, built from its package, and the program installed under target/
	@tools/step.sh "package" cargo package --quiet --allow-dirty
	@tools/step.sh "install" cargo install --path . --features cli --quiet --root "$${CARGO_TARGET_DIR:-target}/installed"

no-panic: ## list what of Rust's panic machinery is in the encoder's firmware
	@tools/no_panic.sh

bless: ## renew the files that tests compare with
	@FLICR_BLESS=1 FLICR_REQUIRE_QEMU=1 tools/step.sh "renewal of the files that tests compare with" \
		cargo test --quiet --features $(FEATURES) $(BLESSED)
