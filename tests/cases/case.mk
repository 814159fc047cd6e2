# Shared by the Makefiles of the cases, which include it: paths, and the rules that most cases need. A copy of a case needs this
# file and the Python modules beside it.
#
# BIN: folder of the programs; OUT: all that is written; FAST: small meshes, where a case has them.
BIN    ?= ../../../build/bin
PYTHON ?= /usr/bin/python3
FAST   ?=
OUT    ?= $(if $(FAST),out-fast,out)

REDUCE = $(BIN)/cbr-reduce
DYN    = $(BIN)/cbr-dyn
BLOCK  = ../../../meshes/block.geo
# Program and arguments of `make check`
CHECK  = check.py $(OUT)

.DEFAULT_GOAL = all
.PHONY: all check clean
.SECONDARY:

# A mesh of the geometry that is the first prerequisite; $(call mesh,NAME=VALUE ...) sets numbers of the geometry.
mesh = mkdir -p $(OUT) && gmsh -3 -v 1 $< $(foreach set,$(1),-setnumber $(subst =, ,$(set))) -o $@.tmp.msh && mv $@.tmp.msh $@

# Scenes stand beside their meshes. A case with VARIED = SCENE.yaml makes them of that one by its scene.py.
ifdef VARIED
$(OUT)/%.yaml: $(VARIED) scene.py ../variants.py
	@mkdir -p $(OUT)
	$(PYTHON) scene.py $(VARIED) $* > $@.tmp && mv $@.tmp $@
else
$(OUT)/%.yaml: %.yaml
	@mkdir -p $(OUT)
	cp $< $@
endif

# A run: the reduction, which leaves alone what is up to date, and the motion. A case adds its meshes as prerequisites.
$(OUT)/%.h5: $(OUT)/%.yaml $(REDUCE) $(DYN)
	$(REDUCE) -q $< > /dev/null
	$(DYN) -q $< -o $@

# $(call reduction,MESH-MODEL): a superelement, and its times in a file. It is removed first, as cbr-reduce leaves alone what is up
# to date and prints no times then.
define reduction
$(OUT)/$(1).cbr.h5: $(OUT)/$(1).yaml $(OUT)/$(firstword $(subst -, ,$(1))).msh $(REDUCE)
	@rm -f $$@
	$(REDUCE) --verbose $$< > /dev/null 2> $(OUT)/$(1).reduce.txt || { cat $(OUT)/$(1).reduce.txt; exit 1; }
endef

$(REDUCE) $(DYN):
	@echo "$@: no such program: build it, or give its folder as BIN" >&2; exit 1

check:
	$(PYTHON) $(CHECK)

clean:
	rm -rf out out-*
