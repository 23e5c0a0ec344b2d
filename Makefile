# SPDX-License-Identifier: GPL-3.0-or-later
# make demo | test | package | screenshots | bench | measurements | figures | build | lint | sanitize.
# Each installs what it lacks and then calls CMake.
# make package leaves the extension in build/package; make screenshots takes those of the manual.
# make test ONLY=words runs the steps with these words in their name; make figures ONLY="NAME..."
# draws the figures of these names.

.PHONY: demo test package screenshots bench measurements figures build lint sanitize
.PHONY: ready ready-for-tests

demo: build
	python3 blender_tests/run_script.py sample_scenes/demo.py

test: ready-for-tests
	python3 .ci/test.py "$(ONLY)"

package: build ready-for-tests
	python3 packaging/package.py

screenshots: package
	python3 blender_tests/window/screenshots.py

bench: build package
	python3 native/bench/in_environment.py bench.py

measurements: bench
	python3 native/bench/report.py

figures: build
	python3 native/bench/in_environment.py docs/figures/make.py $(ONLY)

build: ready
	cmake --preset release
	cmake --build --preset release

lint: ready-for-tests
	python3 .ci/test.py style

sanitize: ready-for-tests
	python3 .ci/test.py sanitizer

ready:
	native/install_dependencies.sh
	-native/provide_suitesparse.sh

ready-for-tests: ready
	native/install_dependencies.sh tests
