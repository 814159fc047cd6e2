# The two commands of README, and what they are made of. `make help` lists all.
BUILD  ?= build
JOBS   ?= $(shell nproc)
PRESET ?= release
# Debian's own Python: the one that Debian's python3-h5py and python3-matplotlib belong to.
PYTHON ?= /usr/bin/python3
export PYTHON

.PHONY: help packages configure programs build test demo paper fig3 fig5 fig6 fig8 fig9 fig10 fig11 fig12 eqs eq18 dissimilar hertz small-features ordinary-part stress stress-table load seeds fuzz sanitize bench bench-docs bench-peers bench-contact peer-decks install deb check clean test-mpi test-kernels
.DEFAULT_GOAL := help

help:
	@echo "make demo      packages, build, the paper's block impact through all three programs, plots"
	@echo "make paper     every figure and table of the paper, and a contents page, in $(BUILD)/paper (an hour; FAST=1: smaller meshes, two minutes)"
	@echo "make fig5      one of them, with FAST=1 too (then in $(BUILD)/paper-fast): $(PAPER)"
	@echo "make dissimilar  the paper's second example, sphere and brick against a dense block: runs, plots, table (5 minutes)"
	@echo "make hertz       steel balls on each other and on a plane against Hertz: runs, plots, table (5 minutes)"
	@echo "make small-features  a bracket with fillets and holes hits a wall, full meshes against superelements: runs, plots, table (3 minutes)"
	@echo "make ordinary-part  a part without small features falls onto a floor, full mesh against superelements: runs, plots, table (3 minutes)"
	@echo "make stress    the stress table into docs/stability-rows.md (a minute), then load, seeds, fuzz"
	@echo "make stress-table  the table alone"
	@echo "make load      1000 instances, 200 000 contact nodes, 10 million outputs, scenes of 100 MB: how time and memory grow, into docs/stability-load.md (six minutes, 8 GB)"
	@echo "make seeds     random scenes against what must not change them and dense arithmetic: SEEDS=FIRST:COUNT (1000:1000; half an hour)"
	@echo "make fuzz      fuzzers of all readers, each for MINUTES=1; TARGETS=\"scene gmsh exodus med superelement edits program checkpoint\"; needs clang"
	@echo "make sanitize  all tests under the address and undefined-behaviour sanitizers, in build-debug (an hour)"
	@echo "make bench     run time against error, reduction, skipping, small features: CSV and plots in $(BUILD)/bench (an hour, with r = 4 half an hour more; SMOKE=1: seconds)"
	@echo "make bench-docs  the tables and plots of docs/benchmarks.md from $(BUILD)/bench"
	@echo "make bench-peers  cbr beside the peers on PATH (CalculiX, OpenRadioss, SciPy, Chrono), one thread, processor seconds (hours with CalculiX; ONLY='T1, r = 0.5; OpenRadioss': some rows, by a regex; LIMIT=600: seconds of a process)"
	@echo "make peer-decks DECKS=FOLDER  tries every deck of the folder (.inp, .bdf, ...; CalculiX's are Debian's calculix-ccx-test): counts of those read and refused, each answer in $(BUILD)/peer-decks.tsv (some minutes)"
	@echo "make bench-contact  seconds a step against contact nodes, 100 to 10 000, by phase (5 minutes)"
	@echo "make test      packages, build, all tests"
	@echo "make test-kernels  all tests with each set of OpenBLAS's kernels that the processor can run, one thread and two (hours; ONLY=REGEX: some)"
	@echo "make test-mpi  packages of packages-mpi.txt, cbr-reduce with MPI in $(BUILD)/mpi, reductions in 2 and 3 processes against one (two minutes)"
	@echo "make programs  the three programs, in $(BUILD)/bin"
	@echo "make build     the programs, the tests and the benchmarks"
	@echo "make check     include directions, counts and other house rules, without building"
	@echo "make packages  install the Debian packages of packages.txt (apt-get; sudo when not root)"
	@echo "make install   build and install under PREFIX (default /usr/local)"
	@echo "make deb       build a Debian package of the programs, $(BUILD)/cbr_*.deb"
	@echo "make clean     remove $(BUILD) and what the examples wrote"

packages:
	@scripts/install-packages packages.txt

configure: packages
	cmake --preset $(PRESET) -B $(BUILD)

programs: configure
	cmake --build $(BUILD) --parallel $(JOBS) --target cbr-reduce cbr-skin cbr-dyn

build: configure
	cmake --build $(BUILD) --parallel $(JOBS)

test: build check
	ctest --test-dir $(BUILD) --output-on-failure --parallel $(JOBS)

# Round-off differs between the kernels of OpenBLAS. ONLY=REGEX: some tests; KERNELS="Haswell Zen": some kernels
test-kernels: build
	$(PYTHON) tests/kernels.py $(BUILD) --parallel $(JOBS) $(if $(ONLY),-R "$(ONLY)")

# docs/distributed.md; after `make test` only the sources of reducer/distributed are left to compile
test-mpi: packages
	@scripts/install-packages packages-mpi.txt
	cmake --preset $(PRESET) -B $(BUILD) -DCBR_MPI=ON
	cmake --build $(BUILD) --parallel $(JOBS) --target cbr-reduce cbr-dyn cbr-reduce-mpi
	$(PYTHON) tests/distributed/check.py $(BUILD)/bin $(BUILD)/mpi

check:
	@$(PYTHON) tests/check_includes.py
	@$(PYTHON) tests/check_statements.py
	@$(PYTHON) tests/check_equations.py
	@$(PYTHON) tests/check_counts.py
	@$(PYTHON) tests/package/check_container.py

demo: programs
	$(MAKE) -C tests/cases/block-impact BIN=$(abspath $(BUILD))/bin
	@echo
	@echo "Done. In tests/cases/block-impact/out:"
	@echo "  block-impact.png  superelements that stick and that rebound (the plot in README.md)"
	@echo "  waves/waves.gif   stress waves in the full meshes"
	@echo "  fig3, fig5, fig6  the paper's figures (docs/reproducing-the-paper.md)"
	@echo "  figures.txt       speeds, energies and errors of all runs"

# docs/reproducing-the-paper.md
PAPER = fig3 fig5 fig6 fig8 fig9 fig10 fig11 fig12 eqs eq18
paper $(PAPER): programs
	cmake --build $(BUILD) --parallel $(JOBS) --target analytic_accelerated_interface
	$(MAKE) -C tests/cases/paper $(if $(filter paper,$@),all,$@) BIN=$(abspath $(BUILD))/bin OUT=$(abspath $(BUILD))/paper$(if $(FAST),-fast) FAST=$(FAST)

dissimilar: programs
	$(MAKE) -C tests/cases/dissimilar-blocks all check BIN=$(abspath $(BUILD))/bin

hertz: programs
	cmake --build $(BUILD) --parallel $(JOBS) --target graded-ball
	$(MAKE) -C tests/cases/hertz check all BIN=$(abspath $(BUILD))/bin

small-features: programs
	$(MAKE) -C tests/cases/small-features all check BIN=$(abspath $(BUILD))/bin

ordinary-part: programs
	$(MAKE) -C tests/cases/ordinary-part all check BIN=$(abspath $(BUILD))/bin

# docs/stability*.md, made by the run
stress: stress-table load seeds fuzz
stress-table: programs
	$(MAKE) -C tests/stability table BIN=$(abspath $(BUILD))/bin JOBS=$(JOBS)

load: programs
	$(MAKE) -C tests/stability load BIN=$(abspath $(BUILD))/bin ONLY="$(ONLY)"

# CONTRIBUTING.md, "Random scenes and fuzzers"
SEEDS ?= 1000:1000
seeds: configure
	cmake --build $(BUILD) --parallel $(JOBS) --target random_scenes
	CBR_SEEDS=$(SEEDS) $(BUILD)/tests/stability/random_scenes

MINUTES ?= 1
TARGETS ?= scene gmsh exodus med superelement edits program checkpoint
fuzz: packages
	cmake --preset fuzz
	cmake --build --preset fuzz --parallel $(JOBS)
	tests/fuzz/run.sh build-fuzz $(MINUTES) $(TARGETS)

# The kernels of 2004, with which OpenBLAS runs where it does not know the processor, read vectors beyond their end (dsymv)
# The kernels: as in tests/fuzz/run.sh
sanitize: packages
	cmake --preset debug
	cmake --build --preset debug --parallel $(JOBS)
	if grep -qs avx2 /proc/cpuinfo; then export OPENBLAS_CORETYPE=$${OPENBLAS_CORETYPE:-Haswell}; fi; ctest --preset debug --parallel $(JOBS)

bench: programs
	cmake --build $(BUILD) --parallel $(JOBS) --target bench_machine
	$(MAKE) -C tests/benchmarks all check BIN=$(abspath $(BUILD))/bin BENCH=$(abspath $(BUILD))/tests/benchmarks OUT=$(abspath $(BUILD))/bench$(if $(SMOKE),-smoke) SMOKE=$(SMOKE)

bench-docs:
	$(MAKE) -C tests/benchmarks docs OUT=$(abspath $(BUILD))/bench

bench-peers: programs
	$(MAKE) -C tests/benchmarks peers plots BIN=$(abspath $(BUILD))/bin BENCH=$(abspath $(BUILD))/tests/benchmarks OUT=$(abspath $(BUILD))/bench ONLY="$(ONLY)" LIMIT=$(LIMIT)

DECKS ?= /usr/share/doc/calculix-ccx-test/examples/test
peer-decks: programs
	$(PYTHON) tests/formats/peer_decks.py $(BUILD)/bin/cbr-dyn "$(DECKS)" $(BUILD)/peer-decks.tsv

bench-contact: configure
	cmake --build $(BUILD) --parallel $(JOBS) --target bench_contact_cost
	$(BUILD)/tests/benchmarks/bench_contact_cost 10000 1100 | tee $(BUILD)/contact-cost.csv
	$(PYTHON) tests/benchmarks/plots.py $(BUILD)/contact-cost.csv $(BUILD)/contact-cost.png

PREFIX ?= /usr/local
install: programs
	cmake --install $(BUILD) --prefix $(PREFIX)

deb: programs
	cpack --config $(BUILD)/CPackConfig.cmake -B $(BUILD)

clean:
	rm -rf $(BUILD)
	$(MAKE) -C tests/cases/block-impact clean
	$(MAKE) -C tests/cases/dissimilar-blocks clean
	$(MAKE) -C tests/cases/hertz clean
	$(MAKE) -C tests/cases/sharp-load clean
	$(MAKE) -C tests/cases/small-features clean
	$(MAKE) -C tests/cases/ordinary-part clean
	$(MAKE) -C tests/cases/decomposition clean
	$(MAKE) -C tests/cases/paper clean
