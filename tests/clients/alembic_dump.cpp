// Prints what Alembic's own library reads in a file, in the form of tests/embedding/alembic_dump.txt, which it has made.
// No Debian that the project builds on has that library; in a newer one:
//   apt-get install g++ libalembic-graphics-dev
//   g++ -std=c++17 -I/usr/include/Imath alembic_dump.cpp -lAlembic -lImath -o alembic_dump && ./alembic_dump FILE.abc
#include <Alembic/AbcCoreOgawa/All.h>

#include <cstdio>

namespace abc = Alembic::AbcCoreAbstract;
namespace util = Alembic::Util;

namespace {

void print_number(const void* values, util::PlainOldDataType pod, std::size_t i) {
  switch (pod) {
    case util::kBooleanPOD:
    case util::kUint8POD:
      std::printf(" %d", static_cast<const unsigned char*>(values)[i]);
      break;
    case util::kUint32POD:
      std::printf(" %u", static_cast<const util::uint32_t*>(values)[i]);
      break;
    case util::kInt32POD:
      std::printf(" %d", static_cast<const util::int32_t*>(values)[i]);
      break;
    case util::kFloat32POD:
      std::printf(" %.9g", double(static_cast<const float*>(values)[i]));
      break;
    case util::kFloat64POD:
      std::printf(" %.17g", static_cast<const double*>(values)[i]);
      break;
    default:
      std::printf(" ?");
  }
}

void print_header(const abc::PropertyHeader& header, const char* kind, std::size_t num_samples, bool is_constant) {
  std::printf("%s %s: %s x %d, samples %zu%s, cycle %.9g, start %.9g", kind, header.getName().c_str(),
              util::PODName(header.getDataType().getPod()), int(header.getDataType().getExtent()), num_samples,
              is_constant ? " constant" : "", header.getTimeSampling()->getTimeSamplingType().getTimePerCycle(),
              header.getTimeSampling()->getSampleTime(0));
  std::printf(" [%s]\n", header.getMetaData().serialize().c_str());
}

void print_array(abc::ArrayPropertyReaderPtr property) {
  print_header(property->getHeader(), "array", property->getNumSamples(), property->isConstant());
  const std::size_t count = property->isConstant() ? 1 : property->getNumSamples();
  for (std::size_t s = 0; s < count; ++s) {
    abc::ArraySamplePtr sample;
    property->getSample(abc::index_t(s), sample);
    abc::ArraySampleKey key;
    property->getKey(abc::index_t(s), key);
    std::printf(" %s:", key.digest.str().c_str());
    const std::size_t numbers = sample->size() * sample->getDataType().getExtent();
    for (std::size_t i = 0; i < numbers; ++i) print_number(sample->getData(), sample->getDataType().getPod(), i);
    std::printf("\n");
  }
}

void print_scalar(abc::ScalarPropertyReaderPtr property) {
  print_header(property->getHeader(), "scalar", property->getNumSamples(), property->isConstant());
  const std::size_t count = property->isConstant() ? 1 : property->getNumSamples();
  for (std::size_t s = 0; s < count; ++s) {
    double values[64];
    property->getSample(abc::index_t(s), values);
    for (int i = 0; i < int(property->getHeader().getDataType().getExtent()); ++i)
      print_number(values, property->getHeader().getDataType().getPod(), std::size_t(i));
    std::printf("\n");
  }
}

void print_properties(abc::CompoundPropertyReaderPtr parent) {
  for (std::size_t i = 0; i < parent->getNumProperties(); ++i) {
    const abc::PropertyHeader& header = parent->getPropertyHeader(i);
    if (header.isCompound()) {
      std::printf("compound %s [%s]\n", header.getName().c_str(), header.getMetaData().serialize().c_str());
      print_properties(parent->getCompoundProperty(header.getName()));
      std::printf("end of %s\n", header.getName().c_str());
    } else if (header.isArray()) {
      print_array(parent->getArrayProperty(header.getName()));
    } else {
      print_scalar(parent->getScalarProperty(header.getName()));
    }
  }
}

void print_object(abc::ObjectReaderPtr object) {
  for (std::size_t i = 0; i < object->getNumChildren(); ++i) {
    const abc::ObjectReaderPtr child = object->getChild(i);
    std::printf("object %s [%s]\n", child->getFullName().c_str(), child->getMetaData().serialize().c_str());
    print_properties(child->getProperties());
    print_object(child);
  }
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) print_object(Alembic::AbcCoreOgawa::ReadArchive()(argv[i])->getTop());
}
