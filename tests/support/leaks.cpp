// The leak checker of a test under AddressSanitizer: leaks.supp names what is not ours.
#ifdef __SANITIZE_ADDRESS__
extern "C" const char* __lsan_default_options();
extern "C" const char* __lsan_default_options() {
  return "print_suppressions=0:suppressions=" SCREE_LEAKS;
}

// A driver that is unloaded takes along the name by which its leaks are known: none is.
extern "C" int dlclose(void*);
extern "C" int dlclose(void*) { return 0; }
#endif
